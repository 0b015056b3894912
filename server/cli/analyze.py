"""The verb `varil analyze` and its options."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from server.cli.choices import Mode
from server.cli.output import AsJson, report


def analyze(
    file: Annotated[Path, typer.Argument(help="A zip as `varil export` writes it.")],
    out: Annotated[Path, typer.Option(help="Folder for report.html, tables and figures.")],
    mode: Annotated[
        Mode | None,
        typer.Option(help="Whose rows; default the live ones, else the only mode there is."),
    ] = None,
    planned: Annotated[
        int | None,
        typer.Option(min=3, help="The planned number of participants, for detectable differences."),
    ] = None,
    keep_marked: Annotated[
        bool, typer.Option("--keep-marked", help="Count what the study's exclusion rules mark.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Test, describe and draw the data of an export, in one report."""
    from server.analysis.run import AnalysisOptions
    from server.analysis.run import analyze as run_analysis

    options = AnalysisOptions(file, out, mode.value if mode else None, planned, keep_marked)
    summary = run_analysis(options)
    if as_json:
        report(summary, as_json)
        return
    findings = summary.pop("findings")
    summary["conditions"] = ", ".join(summary["conditions"])
    report(summary, as_json)
    for finding in findings:
        typer.echo(f"- {finding}")
