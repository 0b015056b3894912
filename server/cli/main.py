"""The `varil` command: serving, migrating, simulating, exporting, analysing, measuring, accounts.

Errors go to stderr: exit code 2 for a wrong call, 1 for a failure.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

import typer
from pydantic import ValidationError

from server.cli.accounts import user
from server.cli.analyze import analyze
from server.cli.bench import bench
from server.cli.data import erase, export, replay
from server.cli.doctor import doctor
from server.cli.evaluate import evaluate
from server.cli.learn import learn
from server.cli.rehearse import rehearse
from server.cli.serve import migrate, serve
from server.cli.simulate import simulate
from server.cli.study import describe_problems, init, problem_lines, validate
from study.errors import StudyError, StudyFileError, UnknownStudy

VERBS = (
    serve, migrate, init, validate, simulate, learn, evaluate, rehearse, export, analyze, replay,
    erase, doctor,
)  # fmt: skip

app = typer.Typer(
    name="varil",
    help="An experiment server for studies of people who work with teams of robots.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
app.add_typer(user, name="user")
app.add_typer(bench, name="bench")

for verb in VERBS:
    app.command()(verb)


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
