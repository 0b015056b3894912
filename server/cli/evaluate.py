"""The verb `varil evaluate` and its options."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from server.cli.output import AsJson, report


def evaluate(
    folders: Annotated[
        list[Path], typer.Argument(help="Folders that learn or simulate filled, or above them.")
    ],
    out: Annotated[Path, typer.Option(help="Folder for figures and tables.")],
    as_json: AsJson = False,
) -> None:
    """Draw the paper's figures and compare displays, from learn's and simulate's output."""
    from server.evaluation.run import evaluate as run_evaluation

    summary = run_evaluation(folders, out)
    if not as_json:
        for note in summary.pop("notes"):
            typer.echo(f"Note: {note}", err=True)
        summary = {
            name: ", ".join(value) if isinstance(value, list) else value
            for name, value in summary.items()
        }
    report(summary, as_json)
