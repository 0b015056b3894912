"""The `varil` command: serving, migrating, simulating, exporting, analysing, measuring, accounts.

Errors go to stderr: exit code 2 for a wrong call, 1 for a failure.
"""

from __future__ import annotations

import asyncio
import sys
from collections.abc import Callable
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from pydantic import ValidationError

from server.cli_analyze import analyze
from server.cli_bench import bench
from server.cli_data import erase, export, replay
from server.cli_doctor import doctor
from server.cli_evaluate import evaluate
from server.cli_learn import learn
from server.cli_output import DatabaseUrl
from server.cli_rehearse import rehearse
from server.cli_simulate import simulate
from server.cli_study import describe_problems, init, problem_lines, validate
from study.errors import InvalidValue, NotFound, StudyError, StudyFileError, UnknownStudy

if TYPE_CHECKING:
    from server.settings import Settings

app = typer.Typer(
    name="varil",
    help="An experiment server for studies of people who work with teams of robots.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
user = typer.Typer(help="Accounts of staff.", no_args_is_help=True)
app.add_typer(user, name="user")
app.add_typer(bench, name="bench")


class Role(StrEnum):
    """What an account may open."""

    ADMIN = "admin"
    EXPERT = "expert"


@app.command()
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


@app.command()
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


VERBS = (
    init, validate, simulate, learn, evaluate, rehearse, export, analyze, replay, erase, doctor,
)  # fmt: skip
for verb in VERBS:
    app.command()(verb)


@user.command("add")
def add_user(
    name: str,
    role: Annotated[Role, typer.Option(help="What the account may open.")],
    password_stdin: Annotated[bool, typer.Option(help="Read the password from stdin.")] = False,
    database_url: DatabaseUrl = None,
) -> None:
    """Add an account, or renew the role and password of one that exists."""
    from server.accounts import add_user as store_account
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


def read_settings(**given: Any) -> Settings:
    """Settings from the environment, with what the command line gave on top."""
    from pydantic_settings import SettingsError

    from server.settings import Settings

    try:
        return Settings(**{name: value for name, value in given.items() if value is not None})
    except SettingsError as error:
        raise InvalidValue(
            f"the environment cannot be read ({error})",
            next_step='Lists are written as JSON, as in VARIL_ALLOWED_ORIGINS=["https://a.example"].',
        ) from error


def require_database(settings: Settings) -> None:
    """Raise `NotFound` where a SQLite file does not exist yet: reading verbs make none."""
    from server.store.engine import sqlite_file

    file = sqlite_file(settings.database)
    if file is not None and not file.is_file():
        raise NotFound(
            f"there is no database at {file}",
            next_step="Run this where `varil serve` runs, or give --database-url.",
        )


def main() -> None:
    """Entry point: every error becomes one sentence and an exit code."""
    sys.exit(run_command(app))


def explain(error: StudyError) -> str:
    """The error's sentence, worded for whoever runs the server where pages word it for others."""
    from server.store.engine import StorageAway

    if isinstance(error, UnknownStudy):
        return f"there is no study “{error.study_id}” in this database. Check --study."
    if isinstance(error, StudyFileError):
        lines = problem_lines(describe_problems(error))
        return "\n  ".join([f"{error.where}: {error.what}.", *lines])
    if isinstance(error, StorageAway):
        return (
            f"the database does not answer ({error.__cause__ or 'no reason given'}). "
            "Check that it runs and that VARIL_DATABASE_URL names it."
        )
    return error.sentence


def run_command(command: Callable[..., Any]) -> int:
    """Run a command and return its exit code."""
    try:
        command(standalone_mode=True)
    except StudyError as error:
        typer.echo(f"varil: {explain(error)}", err=True)
        return 1
    except OSError as error:
        place = f" {error.filename}" if error.filename else ""
        typer.echo(
            f"varil: cannot use{place} ({error.strerror or error}). "
            "Choose another place, or mend its permissions.",
            err=True,
        )
        return 1
    except ValidationError as error:
        for problem in error.errors():
            name = "VARIL_" + "_".join(str(part) for part in problem["loc"]).upper()
            typer.echo(f"varil: the setting {name} is wrong: {problem['msg']}.", err=True)
        return 2
    except KeyboardInterrupt:
        typer.echo("varil: stopped.", err=True)
        return 130
    except SystemExit as leaving:
        return leaving.code if isinstance(leaving.code, int) else 1
    return 0
