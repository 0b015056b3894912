"""The figures and tables of `make results`, from its findings."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from server.evaluation.run import DIFFERENCES_HEADER, Row, difference_row
from server.results.findings import REFERENCES, Findings
from study.analysis.curves import draw_discrepancies
from study.analysis.drawing import SIMULATED, Chart
from study.analysis.forest import Entry, draw_forest
from study.analysis.histograms import draw_histogram
from study.learning.controls import CONTROLS

WAITING = "waiting of all robots in a trial, added up (s)"
SHORTER = "seconds per trial; left of 0: shorter; 95 % bootstrap interval"
SIDES_HEADER = ("way", "elements_that_differ", "shown_share")
MEANS_HEADER = ("group", "runs", "seeds", "sum_wait_s", "low", "high")


def draw_figures(found: Findings) -> dict[str, Chart]:
    """Every figure by its file's name."""
    charts = {}
    last = f"P{len(found.modes[0].steps)}"
    for mode in found.modes:
        charts[f"discrepancies-{mode.name}"] = draw_discrepancies(
            mode.found,
            title=f"Discrepancies between policy and expert, boxes {mode.name}",
            mark=SIMULATED,
        )
        names = ["full", *(f"{name} {mode.name}" for name, _, _ in mode.steps[1:])]
        labels = dict(zip(names, (name for name, _, _ in mode.steps), strict=True))
        title = f"Waiting under the policies P1 to {last}, boxes {mode.name}"
        charts[f"waits-policies-{mode.name}"] = _waits(found, names, title, labels)
    finals = [f"{last} {mode.name}" for mode in found.modes]
    names = [*finals, *REFERENCES, "none", "full", *CONTROLS]
    names += [name for name in found.waits if name.endswith(" worker")]
    charts["waits-conditions"] = _waits(found, names, "Waiting by display and control", {})
    charts["differences"] = draw_forest(
        list(_differences(found, last)),
        title="Differences in waiting on common seeds",
        x_label=SHORTER,
        mark=SIMULATED,
    )
    charts["sides"] = draw_forest(
        [Entry(side.name, f"{last} minus ARROCH", side.pair.seconds) for side in found.sides],
        title=f"{last} minus ARROCH with other experts, classifiers and pairs",
        x_label=SHORTER,
        mark=SIMULATED,
    )
    charts["sensitivity"] = draw_forest(
        list(_changes(found)),
        title=f"{last} minus ARROCH with one parameter changed",
        x_label=f"{SHORTER}; dotted: nothing changed",
        mark=SIMULATED,
        base=found.base.seconds.mean,
    )
    return charts


def make_tables(found: Findings) -> dict[str, tuple[Sequence[str], list[Row]]]:
    """Every table by its file's name."""
    means: list[Row] = [
        (name, len(found.waits[name].runs), mean.n, *_rounded(mean.mean, mean.low, mean.high))
        for name, mean in found.means.items()
    ]
    pairs = [
        difference_row(measure, pair)
        for mode in found.modes
        for pairs in mode.shorter.values()
        for measure, pair in pairs.items()
    ]
    pairs += [
        difference_row("sum_wait_s", pair)
        for each in found.controls.values()
        for pair in each.values()
    ]
    pairs += [difference_row("sum_wait_s", side.pair) for side in found.sides]
    sides: list[Row] = [(side.name, *_rounded(side.differing, side.shown)) for side in found.sides]
    return {
        "means": (MEANS_HEADER, means),
        "paired": (DIFFERENCES_HEADER, pairs),
        "ways": (SIDES_HEADER, sides),
    }


def _waits(found: Findings, names: Sequence[str], title: str, labels: dict[str, str]) -> Chart:
    return draw_histogram(
        {name: found.waits[name].values for name in names},
        title=title,
        x_label=WAITING,
        y_label="trials",
        mark=SIMULATED,
        labels=labels,
    )


def _differences(found: Findings, last: str) -> Iterator[Entry]:
    for mode in found.modes:
        for reference in REFERENCES:
            pair = mode.shorter[reference]["sum_wait_s"]
            yield Entry(f"{last} {mode.name}", f"minus {reference}", pair.seconds)
    for name, pairs in found.controls.items():
        for reference, pair in pairs.items():
            yield Entry(name, f"minus {reference}", pair.seconds)


def _changes(found: Findings) -> Iterator[Entry]:
    for change, pair in found.changed.items():
        what, _, word = change.rpartition(", ")
        yield Entry(what, word, pair.seconds)


def _rounded(*values: float) -> tuple[float, ...]:
    return tuple(round(value, 4) for value in values)
