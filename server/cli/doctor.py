"""The verb `varil doctor`."""

from __future__ import annotations

import json

import typer

from server.cli.context import read_settings
from server.cli.output import AsJson, DatabaseUrl

GREEN, RED = typer.colors.GREEN, typer.colors.RED


def doctor(database_url: DatabaseUrl = None, as_json: AsJson = False) -> None:
    """Check the installation: everything green, or what is wrong and what to do."""
    from server.health import examine

    checks = examine(read_settings(database_url=database_url))
    is_well = all(check.is_well for check in checks)
    if as_json:
        told = [
            {"name": c.name, "ok": c.is_well, "found": c.found, "next_step": c.next_step}
            for c in checks
        ]
        typer.echo(json.dumps({"ok": is_well, "checks": told}))
    else:
        width = max(len(check.name) for check in checks)
        for check in checks:
            mark = typer.style("ok  ", GREEN) if check.is_well else typer.style("FAIL", RED)
            typer.echo(f"{mark}  {check.name:<{width}}  {check.found}")
            if not check.is_well:
                typer.echo(f"      {'':<{width}}  {check.next_step}")
    if not is_well:
        raise typer.Exit(1)
