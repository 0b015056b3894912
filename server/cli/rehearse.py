"""The verb `varil rehearse` and its options."""

from __future__ import annotations

import asyncio
import os
import statistics
from collections import defaultdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from server.cli.output import AsJson, report
from study.errors import InvalidValue

if TYPE_CHECKING:
    from server.rehearsal.run import Outcome

PASSWORD = "VARIL_ADMIN_PASSWORD"  # noqa: S105 - the variable's name
MOST_PROBLEMS = 10


def rehearse(
    url: Annotated[str, typer.Option(help="Address of the running server.")] = (
        "http://127.0.0.1:8000"
    ),
    participants: Annotated[int, typer.Option(min=1, max=1000)] = 24,
    seed: Annotated[int, typer.Option(min=0, max=2**53)] = 0,
    out: Annotated[Path, typer.Option(help="Folder for rehearsal.zip and the report.")] = Path(
        "rehearsal"
    ),
    study: Annotated[
        str, typer.Option(help="The study's id, as in /s/<id>; default the server's only one.")
    ] = "",
    user: Annotated[str, typer.Option(help="The administrator's account.")] = "admin",
    password_file: Annotated[
        Path | None, typer.Option(help=f"File with the password; default ${PASSWORD}.")
    ] = None,
    dropout: Annotated[
        float, typer.Option(min=0.0, max=1.0, help="Share who leave for good without a word.")
    ] = 0.1,
    withdraw: Annotated[float, typer.Option(min=0.0, max=1.0, help="Share who withdraw.")] = 0.05,
    reload: Annotated[
        float, typer.Option(min=0.0, max=1.0, help="Share who load pages and trials again.")
    ] = 0.2,
    late: Annotated[
        float, typer.Option(min=0.0, max=1.0, help="Share who answer late, and twice.")
    ] = 0.2,
    as_json: AsJson = False,
) -> None:
    """Let simulated participants take part on a running server, up to the report.

    Ends with a launch checklist; the exit code is 1 unless all of it is green.
    """
    password = _read_password(password_file)  # before the slow imports: it may be missing

    from server.rehearsal.run import RehearsalOptions
    from server.rehearsal.run import rehearse as run_rehearsal
    from server.rehearsal.site import Site

    options = RehearsalOptions(url, participants, seed, out, study, dropout, withdraw, reload, late)

    async def run() -> Outcome:
        site = Site(url)
        await site.sign_in(user, password)
        return await run_rehearsal(options, site, lambda line: typer.echo(line, err=True))

    outcome = asyncio.run(run())
    if as_json:
        report(outcome.to_json(), as_json)
    else:
        _print(outcome)
    if not outcome.is_green:
        raise typer.Exit(1)


def _read_password(file: Path | None) -> str:
    if file is not None:
        return file.read_text().strip("\r\n")
    if PASSWORD not in os.environ:
        raise InvalidValue(
            "no administrator's password was given",
            next_step=f"Set {PASSWORD} to the one that `varil serve` printed at its first start, "
            "or name a file that holds it with --password-file.",
        )
    return os.environ[PASSWORD]


def _print(outcome: Outcome) -> None:
    summary = outcome.to_json()
    names = ("participants", "completed", "dropped", "withdrew", "errors", "wall_s")
    report({name: summary[name] for name in names}, as_json=False)
    times: dict[str, list[float]] = defaultdict(list)
    for story in outcome.stories:
        for step, seconds in story.times:
            times[step.rstrip("-0123456789")].append(seconds)
    typer.echo("\nSeconds for a step (median, longest)")
    for step, all_s in times.items():
        typer.echo(f"  {step:<15}{statistics.median(all_s):8.2f}{max(all_s):8.2f}")
    typer.echo("\nLaunch checklist")
    for check in outcome.checks:
        sign, colour = ("ok ", "green") if check.passed else ("NO ", "red")
        typer.secho(f"  {sign} {check.what}", fg=colour, nl=False)
        typer.echo(f": {check.figures}")
    for problem in outcome.problems[:MOST_PROBLEMS]:
        typer.echo(f"  {problem}")
