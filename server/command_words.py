"""Words that several verbs of `varil` share: choices, options, how a summary is told."""

from __future__ import annotations

import json
from enum import StrEnum
from typing import Annotated, Any

import typer

AsJson = Annotated[bool, typer.Option("--json", help="One JSON object as stdout's last line.")]


class Scale(StrEnum):
    """The halls by name."""

    PRACTICE = "practice"
    SMALL = "small"
    STUDY = "study"
    LARGE = "large"
    LAB = "lab"


class Worker(StrEnum):
    """Simulated workers."""

    CYCLIC = "cyclic"
    WANDERER = "wanderer"
    BLOCKER = "blocker"
    BELIEVER = "believer"


class Expert(StrEnum):
    """Simulated experts."""

    TABLE = "table"


class Role(StrEnum):
    """What an account may open."""

    ADMIN = "admin"
    EXPERT = "expert"


class Mode(StrEnum):
    """Whose data to export."""

    LIVE = "live"
    PILOT = "pilot"
    BOT = "bot"


def report(summary: dict[str, Any], as_json: bool) -> None:
    """Print a summary for a person, or as one JSON line for a program."""
    if as_json:
        typer.echo(json.dumps(summary))
        return
    width = max(len(name) for name in summary)
    for name, value in summary.items():
        typer.echo(f"{name.replace('_', ' '):<{width}}  {value}")
