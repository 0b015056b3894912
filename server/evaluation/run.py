"""`varil evaluate`: the paper's figures and tables from what `learn` and `simulate` wrote.

Everything is computed before the first file is written, so a folder of results is never half new.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from server.evaluation.groups import (
    Trials,
    check_one_world,
    flatten_settings,
    group_trials,
    name_ways,
)
from server.evaluation.reading import (
    DISCREPANCIES,
    TIMES,
    TRIALS,
    LearnedRun,
    find_folders,
    read_learned,
    read_trials,
)
from study.analysis.curves import LINES, MEASURES, draw_discrepancies
from study.analysis.drawing import SIMULATED, Chart
from study.analysis.forest import Entry, draw_forest
from study.analysis.histograms import draw_histogram
from study.analysis.intervals import Floats
from study.analysis.paired import Difference, compare_groups, mean_of

BOOTSTRAP_SEED = 1
REFERENCES = ("arroch", "crmiar", "none", "full", "P1")
GROUPS_HEADER = (
    "group", "kind", "measure", "runs", "seeds", "trials", "timed_out", "mean", "low", "high",
)  # fmt: skip
DIFFERENCES_HEADER = (
    "measure", "ours", "theirs", "runs", "seeds", "left_out", "their_mean", "difference", "low",
    "high", "shorter_share", "shorter_low", "shorter_high",
)  # fmt: skip
Row = tuple[str | int | float, ...]


@dataclass
class Evaluation:
    """What an evaluation found: figures and tables by file name, differences, notes."""

    charts: dict[str, Chart] = field(default_factory=dict)
    tables: dict[str, tuple[Sequence[str], list[Row]]] = field(default_factory=dict)
    differences: list[tuple[str, Difference]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def evaluate(places: Sequence[Path], out: Path) -> dict[str, Any]:
    """Evaluate folders, write figures (SVG, PDF, CSV), tables and notes; return the summary.

    Errors: InvalidValue or PolicyError for a folder without output, a damaged table, or output
    that must not be mixed; nothing is written then.
    """
    folders = find_folders(places)
    learned = [read_learned(each) for each in folders if (each / DISCREPANCIES).is_file()]
    sets = [read_trials(each) for each in folders if (each / TRIALS).is_file()]
    found = Evaluation(notes=check_one_world(sets, learned))
    evaluate_learning(learned, found)
    groups = group_trials(sets)
    evaluate_trials(groups, found)
    write_evaluation(found, out)
    return {
        "learning_runs": len(learned),
        "trials": sum(group.count for group in groups),
        "groups": [group.label.name for group in groups],
        "figures": sorted(found.charts),
        "tables": sorted(found.tables),
        "notes": found.notes,
        "people": "simulated",
    }


def evaluate_learning(learned: Sequence[LearnedRun], found: Evaluation) -> None:
    """Draw the discrepancies of each way of learning over its runs."""
    ways = name_ways(run.settings for run in learned)
    for way, name in ways.items():
        runs = [run for run in learned if frozenset(flatten_settings(run.settings).items()) == way]
        seeds = [run.settings.get("seed") for run in runs]
        if len(set(seeds)) < len(seeds):
            found.notes.append(f"Learning runs{_of(name)}: a seed is there more than once.")
        if len(runs) == 1:
            found.notes.append(f"Learning runs{_of(name)}: one run only, so there is no band.")
        title = "Discrepancies between policy and expert" + _of(name)
        chart = draw_discrepancies(stack_runs(runs), title=title, mark=SIMULATED)
        found.charts[_file("discrepancies", name)] = chart


def stack_runs(runs: Sequence[LearnedRun]) -> dict[str, dict[str, Floats]]:
    """One table float64[runs, J] for each measure and line."""
    return {
        measure: {line: np.stack([run.found[measure][line] for run in runs]) for line in LINES}
        for measure in MEASURES
    }


def evaluate_trials(groups: Sequence[Trials], found: Evaluation) -> None:
    """Draw waits, tabulate means, compare with the references on common seeds."""
    if not groups:
        return
    rows: list[Row] = []
    for group in groups:
        if group.timed_out:
            found.notes.append(f"{group.label.name}: {group.timed_out} trials ended at their cap.")
        rows += _group_rows(group, found.notes)
    found.tables["groups"] = (GROUPS_HEADER, rows)
    _draw_waits(groups, found)
    found.differences = list(_compare(groups, found.notes))
    if found.differences:
        rows = [difference_row(measure, each) for measure, each in found.differences]
        found.tables["differences"] = (DIFFERENCES_HEADER, rows)
        _draw_differences(found)


def write_evaluation(found: Evaluation, out: Path) -> None:
    """Write all figures and tables, and the notes."""
    out.mkdir(parents=True, exist_ok=True)
    for name, chart in found.charts.items():
        write_chart(out, name, chart)
    for name, (header, rows) in found.tables.items():
        write_rows(out / f"{name}.csv", header, rows)
    notes = [f"Made from {SIMULATED}: nothing here speaks about people.", *found.notes]
    (out / "notes.txt").write_text("\n".join(notes) + "\n", encoding="utf-8")


def write_chart(out: Path, name: str, chart: Chart, *, with_pdf: bool = True) -> None:
    """Write a figure as SVG and PDF, and its numbers as CSV beside."""
    (out / f"{name}.svg").write_bytes(chart.svg)
    if with_pdf:
        (out / f"{name}.pdf").write_bytes(chart.pdf)
    write_rows(out / f"{name}.csv", chart.header, chart.rows)


def write_rows(path: Path, header: Iterable[str], rows: Iterable[Row]) -> None:
    """Write a CSV table."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)


def difference_row(measure: str, found: Difference) -> Row:
    """A difference as a row of `DIFFERENCES_HEADER`."""
    seconds, shorter = found.seconds, found.shorter
    figures = (
        found.their_mean, seconds.mean, seconds.low, seconds.high,
        shorter.mean, shorter.low, shorter.high,
    )  # fmt: skip
    what = (measure, found.ours, found.theirs, found.runs, seconds.n, found.left_out)
    return (*what, *(round(value, 4) for value in figures))


def _group_rows(group: Trials, notes: list[str]) -> Iterator[Row]:
    label = group.label
    for measure in TIMES:
        mine = group.groups[measure]
        if not mine.seeds:
            notes.append(f"{label.name}: its runs have no seed in common, so it has no mean.")
            return
        mean = mean_of(mine, BOOTSTRAP_SEED)
        counts = (len(mine.runs), mean.n, group.count, group.timed_out)
        bounds = (round(mean.mean, 4), round(mean.low, 4), round(mean.high, 4))
        yield (label.name, label.kind, measure, *counts, *bounds)


def _draw_waits(groups: Sequence[Trials], found: Evaluation) -> None:
    """P1 to P6 of each way of learning, then the last policies beside displays and controls."""
    learned = [group for group in groups if group.label.kind == "learned"]
    ways = list(dict.fromkeys(group.label.way for group in learned if group.label.rank > 0))
    last = []
    for way in ways or [""]:
        mine = [group for group in learned if group.label.rank == 0 or group.label.way == way]
        last += mine[-1:]
        if len(mine) > 1:
            chart = draw_waits(mine, "Waiting under policies in the order learned" + _of(way))
            found.charts[_file("waits-policies", way)] = chart
    others = [group for group in groups if group.label.kind != "learned"]
    if others:
        chart = draw_waits([*last, *others], "Waiting by display and control")
        found.charts["waits-conditions"] = chart


def draw_waits(groups: Sequence[Trials], title: str) -> Chart:
    """The histogram of waiting times that the paper draws, with Gaussian curves."""
    return draw_histogram(
        {group.label.name: group.groups["sum_wait_s"].values for group in groups},
        title=title,
        x_label="waiting of all robots in a trial, added up (s)",
        y_label="trials",
        mark=SIMULATED,
    )


def _compare(groups: Sequence[Trials], notes: list[str]) -> Iterator[tuple[str, Difference]]:
    """Every group against every reference that is there."""
    known = {group.label.name: group for group in groups}
    references = [known[name] for name in REFERENCES if name in known] or list(groups[:1])
    for ours in groups:
        for theirs in references:
            if ours is theirs:
                continue
            for measure in TIMES:
                pair = compare_groups(ours.groups[measure], theirs.groups[measure], BOOTSTRAP_SEED)
                if pair is not None:
                    yield measure, pair
            names = f"{ours.label.name} and {theirs.label.name}"
            if pair is None:
                notes.append(f"{names} have no seed in common: not compared.")
            elif pair.left_out:
                notes.append(f"{names}: {pair.left_out} seeds without a partner were left out.")


def _draw_differences(found: Evaluation) -> None:
    waits = [pair for measure, pair in found.differences if measure == "sum_wait_s"]
    references = list(dict.fromkeys(pair.theirs for pair in waits))[:2]
    entries = [
        Entry(pair.ours, f"minus {pair.theirs}", pair.seconds)
        for pair in waits
        if pair.theirs in references
    ]
    found.charts["waits-differences"] = draw_forest(
        entries,
        title="Differences in waiting on common seeds",
        x_label="seconds per trial; left of 0: shorter than the reference; 95 % bootstrap",
        mark=SIMULATED,
    )


def _of(way: str) -> str:
    return f", {way}" if way else ""


def _file(name: str, way: str) -> str:
    """A file's name for a way of learning: letters, digits and hyphens."""
    words = "".join(sign if sign.isalnum() else " " for sign in way).split()
    return "-".join([name, *words])
