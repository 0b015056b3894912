"""Guards histograms: what is drawn is what the rows say, in the same bytes each time."""

from __future__ import annotations

import numpy as np
import pytest

from study.analysis.drawing import STYLES, style_of
from study.analysis.histograms import HEADER, choose_bins, draw_histogram, round_nicely
from study.errors import InvalidValue

WORDS = {"title": "Waits", "x_label": "s", "y_label": "trials", "mark": "simulated people"}


def groups(*names: str) -> dict[str, np.ndarray]:
    draws = np.random.default_rng(3)
    return {name: draws.normal(100 + 5 * n, 20, 80) for n, name in enumerate(names)}


@pytest.mark.parametrize("names", [("varil", "arroch"), ("P1", "P2", "P3", "P4")])
def test_the_same_numbers_give_the_same_bytes(names: tuple[str, ...]) -> None:
    """No date and no random identifier: a repository sees no change where there is none."""
    chart = draw_histogram(groups(*names), **WORDS)
    assert chart == draw_histogram(groups(*names), **WORDS)
    assert chart.svg.startswith(b"<?xml")
    assert chart.pdf.startswith(b"%PDF-")
    assert b"simulated people" in chart.svg
    for name in names:
        assert f"{name} (n = 80".encode() in chart.svg


def test_rows_hold_every_value_once_and_the_curve() -> None:
    samples = groups("varil", "arroch")
    chart = draw_histogram(samples, **WORDS)
    rows = [dict(zip(HEADER, row, strict=True)) for row in chart.rows]
    for name, sample in samples.items():
        mine = [row for row in rows if row["group"] == name]
        assert sum(int(row["count"]) for row in mine) == len(sample)
        assert float(mine[0]["mean"]) == pytest.approx(sample.mean(), abs=1e-6)
        assert float(mine[0]["sd"]) == pytest.approx(sample.std(ddof=1), abs=1e-6)
        assert sum(float(row["gauss_count"]) for row in mine) == pytest.approx(80, rel=0.05)
        for row in mine:
            inside = (sample >= row["bin_low"]) & (sample < row["bin_high"])
            assert int(inside.sum()) == row["count"]


def test_groups_of_different_size_are_drawn_as_shares() -> None:
    samples = groups("varil", "arroch")
    samples["arroch"] = samples["arroch"][:30]
    assert b"share of trials" in draw_histogram(samples, **WORDS).svg
    assert b"share of" not in draw_histogram(groups("varil", "arroch"), **WORDS).svg


def test_values_without_spread_have_bins_but_no_curve() -> None:
    chart = draw_histogram({"none": [4.0, 4.0]}, **WORDS)
    (row,) = chart.rows
    assert row == ("none", 2, 4.0, 0.0, 3.5, 4.5, 2, 0.0)


def test_bins_are_round_and_hold_all() -> None:
    edges = choose_bins([np.array([3.0, 999.0, 500.0, 510.0])])
    assert edges[0] <= 3.0
    assert edges[-1] > 999.0
    assert len(edges) < 65
    assert [round_nicely(v) for v in (63.0, 80.0, 2.3, 0.011)] == [50.0, 100.0, 2.5, 0.01]


def test_nothing_to_draw_is_said() -> None:
    with pytest.raises(InvalidValue, match="no group"):
        draw_histogram({}, **WORDS)
    with pytest.raises(InvalidValue, match="“P2” has no values"):
        draw_histogram({"P1": [1.0], "P2": []}, **WORDS)


def test_groups_differ_by_more_than_colour() -> None:
    """No two named groups share colour and dashes, nor do the first spare ones."""
    named = [(style.colour, style.dash) for style in STYLES.values()]
    spare = [(style_of("?", n).colour, style_of("?", n).dash) for n in range(12)]
    assert len(set(named)) == len(named)
    assert len(set(spare)) == len(spare)
