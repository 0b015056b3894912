"""The verb `varil user`: accounts of staff."""

from __future__ import annotations

import asyncio
import sys
from enum import StrEnum
from typing import Annotated

import typer

from server.cli.context import read_settings
from server.cli.output import DatabaseUrl

user = typer.Typer(help="Accounts of staff.", no_args_is_help=True)


class Role(StrEnum):
    """What an account may open."""

    ADMIN = "admin"
    EXPERT = "expert"


@user.command("add")
def add_user(
    name: str,
    role: Annotated[Role, typer.Option(help="What the account may open.")],
    password_stdin: Annotated[bool, typer.Option(help="Read the password from stdin.")] = False,
    database_url: DatabaseUrl = None,
) -> None:
    """Add an account, or renew the role and password of one that exists."""
    from server.desks.accounts import add_user as store_account
    from server.store.engine import Database
    from server.store.schema import check_schema, migrate

    if password_stdin:
        password = sys.stdin.readline().rstrip("\r\n")
    else:
        password = typer.prompt("Password", hide_input=True, confirmation_prompt=True)

    async def run() -> bool:
        database = Database(read_settings(database_url=database_url).database)
        try:
            await (check_schema(database) if database.file is None else migrate(database))
            return await store_account(database, name, role.value, password)
        finally:
            await database.close()

    new = asyncio.run(run())
    typer.echo(f"{'Added' if new else 'Renewed'} {name} as {role.value}.")
