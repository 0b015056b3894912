"""Guards bootstrap intervals: seeded, honest about pairs, and right where the answer is known."""

from __future__ import annotations

import numpy as np
import pytest

from study.analysis.intervals import bootstrap_crossed, bootstrap_mean, bootstrap_paired
from study.errors import InvalidValue


def test_the_same_seed_gives_the_same_interval_and_another_does_not() -> None:
    values = np.random.default_rng(1).normal(10, 2, 40)
    assert bootstrap_mean(values, 7) == bootstrap_mean(values, 7)
    assert bootstrap_mean(values, 7) != bootstrap_mean(values, 8)


def test_the_width_is_that_of_the_mean() -> None:
    """For many normal values the interval is close to the mean +- 1.96 standard errors."""
    values = np.random.default_rng(2).normal(0, 1, 2000)
    found = bootstrap_mean(values, 3)
    half = 1.96 * values.std() / np.sqrt(2000)
    assert found.mean == pytest.approx(values.mean())
    assert found.high - found.low == pytest.approx(2 * half, rel=0.06)


def test_pairs_take_out_what_they_share() -> None:
    """A difference of 1 with almost no spread is found under a hundredfold common spread."""
    draws = np.random.default_rng(4)
    common = draws.normal(0, 100, 50)
    found = bootstrap_paired(common + 1 + draws.normal(0, 0.1, 50), common, 5)
    assert found.low < 1 < found.high
    assert found.high - found.low < 0.2
    assert found.excludes_zero


def test_runs_in_common_widen_a_crossed_interval() -> None:
    """Ten runs that differ by much: their trials are no independent values."""
    draws = np.random.default_rng(6)
    table = draws.normal(0, 5, 10)[:, None] + draws.normal(0, 1, (10, 60))
    crossed = bootstrap_crossed(table, 7)
    flat = bootstrap_mean(table.ravel(), 7)
    assert crossed.mean == pytest.approx(flat.mean)
    assert crossed.high - crossed.low > 3 * (flat.high - flat.low)
    assert crossed.n == 60


def test_one_run_is_the_plain_interval() -> None:
    values = np.random.default_rng(8).normal(3, 1, 300)
    crossed, plain = bootstrap_crossed(values[None, :], 9), bootstrap_mean(values, 9)
    assert crossed.low == pytest.approx(plain.low, abs=0.03)
    assert crossed.high == pytest.approx(plain.high, abs=0.03)


def test_one_value_has_no_width() -> None:
    found = bootstrap_mean([2.5], 1)
    assert (found.mean, found.low, found.high, found.n) == (2.5, 2.5, 2.5, 1)


@pytest.mark.parametrize("values", [[], [1.0, float("nan")], [float("inf")]])
def test_nothing_finite_is_refused(values: list[float]) -> None:
    with pytest.raises(InvalidValue, match="finite"):
        bootstrap_mean(values, 1)


def test_halves_of_pairs_are_refused() -> None:
    with pytest.raises(InvalidValue, match="one length"):
        bootstrap_paired([1.0, 2.0], [1.0], 1)
    with pytest.raises(InvalidValue, match="full table"):
        bootstrap_crossed(np.zeros((0, 3)), 1)
