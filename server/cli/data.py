"""The verbs about stored data: `varil export`, `varil replay` and `varil erase`."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Annotated

import typer

from server.cli.choices import Mode
from server.cli.context import read_settings, require_database
from server.cli.output import AsJson, DatabaseUrl, report


def export(
    study: Annotated[str, typer.Option(help="The study's id, as in /s/<id>.")],
    out: Annotated[Path, typer.Option(help="The zip to write, - for stdout.")],
    mode: Annotated[Mode | None, typer.Option(help="Only these participants; default all.")] = None,
    telemetry: Annotated[
        bool, typer.Option(help="Also where each person was, five times a second.")
    ] = False,
    panel_ids: Annotated[
        bool, typer.Option(help="Also what the recruitment panel calls each person.")
    ] = False,
    notes: Annotated[
        bool, typer.Option(help="Also what staff noted about people and moments of trials.")
    ] = False,
    database_url: DatabaseUrl = None,
    as_json: AsJson = False,
) -> None:
    """Write the data of a study as tidy CSV tables in one zip."""
    from server.export.bundle import STDOUT, ExportOptions, write_export

    settings = read_settings(database_url=database_url)
    require_database(settings)
    options = ExportOptions(study, mode.value if mode else None, telemetry, panel_ids, notes)
    counts = asyncio.run(write_export(settings, options, out))
    if out != STDOUT:
        report({"file": str(out), **counts}, as_json)


def replay(
    trial: Annotated[str, typer.Argument(help="The trial's id, from trials.csv.")],
    verify: Annotated[
        bool, typer.Option(help="Only check the stored hashes; exit code 1 if one differs.")
    ] = False,
    policy: Annotated[
        Path | None, typer.Option(help="Policy file: what it would have shown.")
    ] = None,
    trace: Annotated[
        Path | None, typer.Option(help="CSV to write: everybody's place five times a second.")
    ] = None,
    database_url: DatabaseUrl = None,
    as_json: AsJson = False,
) -> None:
    """Simulate a stored trial again and check every state hash that was recorded."""
    from server.policy_files import read_policy_file
    from server.replay.run import load_trial, replay_trial

    settings = read_settings(database_url=database_url)
    require_database(settings)
    other = read_policy_file(policy) if policy else None
    summary = replay_trial(asyncio.run(load_trial(settings, trial)), other, trace)
    if verify and not (policy or trace):
        summary = {key: summary[key] for key in ("trial", "ticks", "hashes_checked", "mismatches")}
    report(summary, as_json)
    if summary["mismatches"] or (verify and not summary["hashes_checked"]):
        raise typer.Exit(1)


def erase(
    participant: Annotated[str, typer.Argument(help="The code, as P-XXXXXXXX.")],
    database_url: DatabaseUrl = None,
    as_json: AsJson = False,
) -> None:
    """Withdraw a participant and delete all their data for good; a tombstone is left."""
    from server.desks.lives import KEPT, LifeDesk
    from server.store.engine import Database
    from server.store.schema import check_schema

    settings = read_settings(database_url=database_url)
    require_database(settings)

    async def run() -> dict[str, int]:
        database = Database(settings.database)
        try:
            await check_schema(database)
            return await LifeDesk(database).erase(participant, "command line")
        finally:
            await database.close()

    gone = asyncio.run(run())
    report({"participant": participant.strip().upper(), **gone, "kept": KEPT}, as_json)
