"""The verbs about study files: `init` begins one, `validate` says what is wrong with one."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from server.cli.output import AsJson
from study.errors import StudyFileError


def init(
    folder: Annotated[Path, typer.Argument(help="A folder that does not exist yet.")],
) -> None:
    """Begin a study: one TOML file, complete and commented, and a README."""
    from server.study_files import begin_study

    for file in begin_study(folder):
        typer.echo(f"Wrote {file}")
    typer.echo(f"Next: change it, then `varil validate {folder / 'study.toml'}`.")


def validate(
    file: Annotated[Path, typer.Argument(help="The study file.")],
    as_json: AsJson = False,
) -> None:
    """Check a study file: every mistake with its place, the value and what is allowed there."""
    from server.study_files import read_study_file

    try:
        study = read_study_file(file).study
    except StudyFileError as error:
        _report(describe_problems(error), as_json)
        raise typer.Exit(1) from None
    except OSError as error:
        message = f"{file} cannot be read ({error.strerror or error})"
        _report([{"path": "", "value": None, "message": message}], as_json)
        raise typer.Exit(1) from None
    if as_json:
        _report([], as_json)
        return
    orders = f"{len(study.orders)} order{'' if len(study.orders) == 1 else 's'}"
    typer.echo(
        f"{file} is valid: “{study.title}”, {len(study.conditions)} conditions in {orders}, "
        f"version {study.config_hash[:12]}."
    )


def describe_problems(error: StudyFileError) -> list[dict[str, Any]]:
    """The problems as plain values: path in the file, value there, what is allowed."""
    from study.protocol.records import show_place

    return [
        {
            "path": show_place(problem.place),
            "value": json.loads(json.dumps(problem.value, default=str)),
            "message": problem.message,
        }
        for problem in error.problems
    ]


def _report(problems: list[dict[str, Any]], as_json: bool) -> None:
    if as_json:
        typer.echo(json.dumps({"valid": not problems, "errors": problems}, ensure_ascii=False))
        return
    for line in problem_lines(problems):
        typer.echo(line, err=True)
    count = "One mistake" if len(problems) == 1 else f"{len(problems)} mistakes"
    typer.echo(f"{count}; nothing was changed.", err=True)


def problem_lines(problems: Sequence[Mapping[str, Any]]) -> list[str]:
    """A line for each problem: `practice.tries = 99: not allowed here; give ...`."""
    lines = []
    for problem in problems:
        shown = json.dumps(problem["value"], ensure_ascii=False)
        value = "" if problem["value"] is None or len(shown) > 60 else f" = {shown}"
        lines.append(f"{problem['path'] or 'the file'}{value}: {problem['message']}.")
    return lines
