"""Guards the curves of learning and the figure of intervals: their numbers are what is drawn."""

from __future__ import annotations

import numpy as np
import pytest

from study.analysis.curves import HEADER, LINES, MEASURES, average_runs, draw_discrepancies
from study.analysis.forest import Entry, draw_forest
from study.analysis.intervals import Interval
from study.errors import InvalidValue


def test_blocks_hold_every_iteration_once() -> None:
    series = np.array([np.arange(10.0), np.arange(10.0) + 4])
    curve = average_runs(series, points=3)
    assert list(zip(curve.first, curve.last, strict=True)) == [(1, 3), (4, 6), (7, 9), (10, 10)]
    assert curve.mean.tolist() == [3.0, 6.0, 9.0, 11.0]
    assert curve.low[0] == pytest.approx(1.4)
    assert curve.high[0] == pytest.approx(4.6)
    assert curve.runs == 2
    with pytest.raises(InvalidValue, match="needs runs"):
        average_runs(np.zeros((0, 5)))


@pytest.mark.parametrize("runs", [1, 3])
def test_the_figure_holds_every_line_of_every_measure(runs: int) -> None:
    draws = np.random.default_rng(runs)
    found = {name: {line: draws.random((runs, 20)) for line in LINES} for name in MEASURES}
    chart = draw_discrepancies(found, title="D", mark="simulated people")
    assert chart == draw_discrepancies(found, title="D", mark="simulated people")
    rows = [dict(zip(HEADER, row, strict=True)) for row in chart.rows]
    assert len(rows) == len(MEASURES) * len(LINES) * 20
    for row in rows:
        column = found[str(row["measure"])][str(row["line"])][:, int(row["first_iteration"]) - 1]
        assert row["mean"] == pytest.approx(column.mean(), abs=1e-6)
        assert row["low"] <= row["mean"] <= row["high"] or runs > 1
    assert b"simulated people" in chart.svg
    assert (b"middle 80" in chart.svg) == (runs > 1)


def test_intervals_are_drawn_as_given() -> None:
    entries = [
        Entry("faster", "halved", Interval(-4.0, -9.0, 1.0, 20)),
        Entry("faster", "doubled", Interval(3.0, 1.0, 5.0, 20)),
    ]
    words = {"title": "T", "x_label": "s", "mark": "simulated people"}
    chart = draw_forest(entries, base=1.0, **words)
    assert chart.rows == (
        ("faster", "halved", 20, -4.0, -9.0, 1.0),
        ("faster", "doubled", 20, 3.0, 1.0, 5.0),
    )
    assert b"doubled" in chart.svg
    assert chart == draw_forest(entries, base=1.0, **words)
    with pytest.raises(InvalidValue, match="no interval"):
        draw_forest([], **words)
