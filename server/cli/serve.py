"""The verbs that run the server and prepare its database: `varil serve` and `varil migrate`."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Annotated

import typer

from server.cli.context import read_settings
from server.cli.output import DatabaseUrl


def serve(
    host: Annotated[str | None, typer.Option(help="Default 127.0.0.1 or VARIL_HOST.")] = None,
    port: Annotated[int | None, typer.Option(help="Default 8000 or VARIL_PORT.")] = None,
    database_url: DatabaseUrl = None,
    study: Annotated[
        list[Path] | None,
        typer.Option(help="A study file; may be given several times. Default the demo study."),
    ] = None,
) -> None:
    """Run the server; brings an embedded database up to date first."""
    from server.serving import serve as run_server
    from server.study_files import read_study_files

    settings = read_settings(
        host=host, port=port, database_url=database_url, study_files=study or None
    )
    run_server(settings, read_study_files(settings.study_files))


def migrate(database_url: DatabaseUrl = None) -> None:
    """Bring the database to the current schema."""
    from server.store.engine import Database
    from server.store.schema import migrate as migrate_database

    async def run() -> tuple[str | None, str]:
        database = Database(read_settings(database_url=database_url).database)
        try:
            return await migrate_database(database)
        finally:
            await database.close()

    before, after = asyncio.run(run())
    if before == after:
        typer.echo(f"The database has the current schema already ({after}).")
    else:
        typer.echo(f"Schema {before or 'none'} -> {after}.")
