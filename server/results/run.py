"""`make results`: learns, simulates and writes docs/results.md with its figures.

    python -m server.results.run [--size full|small|tiny] [--workers N]

`full` writes docs/results.md and docs/results/; other sizes write below var/results, so that a
trial run never replaces the published page. Finished pieces under var/results/pieces are kept and
not run again.
"""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from server.evaluation.run import write_chart, write_rows
from server.headless.backends import Backend
from server.kernel_cache import open_kernel_cache
from server.results.figures import draw_figures, make_tables
from server.results.findings import collect_findings
from server.results.page import write_report
from server.results.pieces import Store, hash_code, library_versions, run_pieces
from server.results.plan import choose_size, plan_learning, plan_trials
from study.headless import simulate_trial
from study.people.worker import BELIEVER
from study.warehouse.layout import PRESETS, build_layout

ROOT = Path(__file__).parents[2]
PUBLISHED = "full"


def make_results(
    size_name: str, backend: Backend, out: Path, store: Path, console: Console
) -> Path:
    """Run what is missing, write results.md and results/ into `out`, return the page.

    Errors: InvalidValue for an unknown size; those of a damaged piece, naming its file.
    """
    size = choose_size(size_name)
    started_s = time.perf_counter()
    console.print("Preparing the compiled world (up to a minute the first time) ...")
    open_kernel_cache()
    simulate_trial(build_layout(PRESETS["practice"]), 0, BELIEVER)
    pieces = Store(store, hash_code())
    learning = plan_learning(size)
    trials = sorted(plan_trials(size), key=lambda piece: -piece.trials)
    run_pieces(learning, "learning runs", pieces, size, backend, console)
    run_pieces(trials, "sets of trials", pieces, size, backend, console)
    console.print("Computing intervals and drawing ...")
    found = collect_findings(size, pieces)
    charts, tables = draw_figures(found), make_tables(found)
    text = write_report(found, size, library_versions(), "results")
    folder = out / "results"
    folder.mkdir(parents=True, exist_ok=True)
    for name, chart in charts.items():
        write_chart(folder, name, chart, with_pdf=False)
    for name, (header, rows) in tables.items():
        write_rows(folder / f"{name}.csv", header, rows)
    page = out / "results.md"
    page.write_text(text, encoding="utf-8")
    total = sum(piece.trials for piece in trials)
    console.print(
        f"{len(learning)} learning runs and {total} trials in "
        f"{time.perf_counter() - started_s:.0f} s: {page}"
    )
    return page


def command(
    size: Annotated[str, typer.Option(help="full, small or tiny.")] = PUBLISHED,
    workers: Annotated[int | None, typer.Option(min=1, help="Processes; default all.")] = None,
) -> None:
    """Make docs/results.md with simulated people, from learning runs to figures."""
    below = ROOT / "var" / "results"
    out = ROOT / "docs" if size == PUBLISHED else below / size
    backend = Backend(processes=workers or os.cpu_count() or 1)
    make_results(size, backend, out, below / "pieces", Console(stderr=True))


if __name__ == "__main__":
    from server.cli.main import run_command

    app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    app.command()(command)
    sys.exit(run_command(app))
