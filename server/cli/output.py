"""Words that the verbs of `varil` share: the database, and results for a person or as JSON."""

from __future__ import annotations

import json
from typing import Annotated, Any

import typer

DatabaseUrl = Annotated[
    str | None,
    typer.Option(help="sqlite:///FILE or postgresql://...; default VARIL_DATABASE_URL."),
]
AsJson = Annotated[bool, typer.Option("--json", help="One JSON object as stdout's last line.")]


def report(summary: dict[str, Any], as_json: bool) -> None:
    """Print a summary for a person, or as one JSON line for a program."""
    if as_json:
        typer.echo(json.dumps(summary))
        return
    width = max(len(name) for name in summary)
    for name, value in summary.items():
        typer.echo(f"{name.replace('_', ' '):<{width}}  {value}")
