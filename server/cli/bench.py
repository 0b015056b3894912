"""`varil bench`: what this machine carries, measured on the real code."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated

import typer

from server.cli.output import AsJson, report

bench = typer.Typer(help="Measurements of this machine.", no_args_is_help=True)


@bench.command("live")
def bench_live(
    levels: Annotated[str, typer.Option(help="Numbers of trials, rising.")] = "100,200,300,400",
    seconds: Annotated[float, typer.Option(min=1.0, help="Measured time per level.")] = 15.0,
    as_json: AsJson = False,
) -> None:
    """How many participants' trials one core carries; about half a minute per level."""
    from server.bench.live import bench_live as measure

    try:
        steps = [int(level) for level in levels.split(",")]
    except ValueError:
        steps = []
    if not steps or steps[0] < 1 or any(b <= a for a, b in pairwise(steps)):
        raise typer.BadParameter("wanted rising numbers of trials, as 100,200", param_hint="levels")
    summary = measure(steps, seconds)
    if not as_json:
        summary |= {f"with_{level['trials']}": level for level in summary.pop("levels")}
    report(summary, as_json)


@bench.command("wire")
def bench_wire(as_json: AsJson = False) -> None:
    """Bytes per second to one participant, counted over whole trials."""
    from server.bench.wire import measure_wire
    from server.kernel_cache import open_kernel_cache

    open_kernel_cache()
    report({name: measure_wire(name) for name in ("varil", "arroch", "crmiar", "none")}, as_json)


@bench.command("replay")
def bench_replay(as_json: AsJson = False) -> None:
    """Seconds to re-simulate five minutes of a trial from its journal."""
    from server.bench.replay import measure_replay
    from server.kernel_cache import open_kernel_cache

    open_kernel_cache()
    report(measure_replay(), as_json)


@bench.command("export")
def bench_export(
    participants: Annotated[int, typer.Option(min=1, help="With three trials each.")] = 1000,
    as_json: AsJson = False,
) -> None:
    """Time and peak memory of exporting a large study; a minute or two for 1000 participants."""
    from server.bench.export import measure_export

    report(measure_export(participants), as_json)


@bench.command("learn")
def bench_learn(
    repeats: Annotated[int, typer.Option(min=1, help="Whole runs of 240 iterations.")] = 5,
    expert: Annotated[str, typer.Option(help="Who sets the boxes: person or table.")] = "person",
    as_json: AsJson = False,
) -> None:
    """Seconds of a learning run with simulated people, and what training takes of it."""
    from server.bench.learn import measure_learning

    report(measure_learning(repeats, expert), as_json)


@bench.command("headless")
def bench_headless(
    repeats: Annotated[int, typer.Option(min=1, help="Measurements of each kind.")] = 5,
    trials: Annotated[int, typer.Option(min=1, help="Trials of each steps' measurement.")] = 20,
    table_trials: Annotated[int, typer.Option(min=0, help="Trials per policy; 0: no table.")] = 250,
    workers: Annotated[int | None, typer.Option(min=1, help="Processes; default all.")] = None,
    as_json: AsJson = False,
) -> None:
    """Steps a second with the believer and a policy, and the time of 6 x 250 trials."""
    from server.bench.headless import measure_headless

    report(measure_headless(repeats, trials, table_trials, workers), as_json)
