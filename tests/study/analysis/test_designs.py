"""Guards complete cases: who counts, who does not, and that everybody is accounted for."""

from __future__ import annotations

import numpy as np
import pytest

from study.analysis.descriptives import summarise
from study.analysis.designs import LeftOut, Reading, complete_cases, order_conditions
from study.analysis.wording import chance, interval, number


def test_everybody_counts_or_is_listed_with_a_reason() -> None:
    readings = [
        Reading("a", "varil", 1, 5.0),
        Reading("a", "none", 2, 6.0),
        Reading("b", "varil", 1, 7.0),
    ]
    design = complete_cases(
        "x", readings, ("varil", "none"), ("a", "b", "c"), {("b", "none"): "timed out"}
    )
    assert design.participants == ("a",)
    assert design.values.tolist() == [[5.0, 6.0]]
    assert design.left_out == (
        LeftOut("b", "none: timed out"),
        LeftOut("c", "varil: no value; none: no value"),
    )
    assert {reading.participant for reading in design.readings} == {"a"}


def test_nobody_is_a_table_of_the_right_shape() -> None:
    assert complete_cases("x", [], ("varil", "none"), (), {}).values.shape == (0, 2)


def test_repeated_trials_of_a_condition_are_averaged() -> None:
    readings = [Reading("a", "varil", 1, 4.0), Reading("a", "varil", 3, 8.0)]
    readings.append(Reading("a", "none", 2, 1.0))
    design = complete_cases("x", readings, ("varil", "none"), ("a",), {})
    assert design.values.tolist() == [[6.0, 1.0]]
    assert len(design.readings) == 3


def test_varil_comes_first() -> None:
    assert order_conditions(["none", "crmiar", "varil", "none"]) == ("varil", "crmiar", "none")


def test_a_summary_as_by_hand() -> None:
    """Quartiles as R's default; t(0.975, 3) = 3.182446."""
    found = summarise(np.array([1.0, 2.0, 3.0, 10.0]))
    assert (found.mean, found.median) == (4.0, 2.5)
    assert (found.lower_quartile, found.upper_quartile) == (1.75, 4.75)
    assert found.sd == pytest.approx(4.082483)
    assert found.high == pytest.approx(4 + 3.182446 * 4.082483 / 2)


def test_a_summary_of_one_and_of_none() -> None:
    one = summarise(np.array([3.0]))
    assert (one.n, one.mean, one.sd, one.low) == (1, 3.0, None, None)
    assert summarise(np.empty(0)).mean is None


def test_numbers_read_as_they_should() -> None:
    """Three digits; a p-value just below 0.05 never reads as 0.050."""
    assert [number(v) for v in (None, 2154.4, 21.46, -2.149, 0.2149)] == [
        "–",
        "2154",
        "21.5",
        "−2.15",
        "0.215",
    ]
    assert [chance(p) for p in (None, 0.0004, 0.0123, 0.0498, 0.05, 1.0)] == [
        "–",
        "< 0.001",
        "0.012",
        "0.0498",
        "0.050",
        "1.000",
    ]
    assert interval((1.0, None, None)) == "1.00"
