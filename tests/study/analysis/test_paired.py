"""Guards paired differences: same seeds only, runs kept apart, and exact where it can be."""

from __future__ import annotations

import numpy as np
import pytest

from study.analysis.paired import Group, compare_groups, mean_of
from study.errors import InvalidValue


def test_only_common_seeds_are_compared() -> None:
    ours = Group("P6", {"a": {1: 10.0, 2: 20.0, 3: 30.0}, "b": {2: 22.0, 3: 32.0, 9: 0.0}})
    theirs = Group("arroch", {"": {2: 25.0, 3: 25.0, 4: 1000.0}})
    found = compare_groups(ours, theirs, 1)
    assert found is not None
    assert found.seconds.mean == pytest.approx((20 + 30 + 22 + 32) / 4 - 25)
    assert found.shorter.mean == pytest.approx(0.5)
    assert (found.seconds.n, found.runs, found.their_mean) == (2, 2, 25.0)
    assert found.left_out == 3  # 1 and 9, which one run lacks, and 4


def test_no_common_seed_is_no_difference() -> None:
    ours, theirs = Group("P6", {"a": {1: 10.0}}), Group("none", {"": {2: 10.0}})
    assert compare_groups(ours, theirs, 1) is None
    with pytest.raises(InvalidValue, match="no seed in common"):
        mean_of(Group("P6", {"a": {1: 1.0}, "b": {2: 1.0}}), 1)


def test_policies_of_one_run_are_paired_by_run() -> None:
    """P6 is 5 below P2 in every run, however far the runs lie apart."""
    draws = np.random.default_rng(3)
    early = {
        run: {seed: offset + draws.normal(0, 1) for seed in range(40)}
        for run, offset in (("a", 0.0), ("b", 300.0), ("c", 900.0))
    }
    late = {run: {seed: value - 5 for seed, value in mine.items()} for run, mine in early.items()}
    found = compare_groups(Group("P6", late), Group("P2", early), 1)
    assert found is not None
    assert found.seconds.low == pytest.approx(-5)
    assert found.seconds.high == pytest.approx(-5)
    assert found.shorter.low == 1.0


def test_runs_of_two_kinds_are_drawn_apart() -> None:
    """Two kinds of learning have no runs in common, so the runs' spread stays in the interval."""
    offsets = {"a": 0.0, "b": 300.0, "c": 900.0}
    mine = {f"x{run}": dict.fromkeys(range(40), value) for run, value in offsets.items()}
    other = {f"y{run}": dict.fromkeys(range(40), value) for run, value in offsets.items()}
    found = compare_groups(Group("P6", mine), Group("P6 other", other), 1)
    assert found is not None
    assert found.seconds.mean == pytest.approx(0)
    assert found.seconds.high - found.seconds.low > 300


def test_an_empty_run_is_refused() -> None:
    with pytest.raises(InvalidValue, match="without trials"):
        Group("P6", {"a": {}})
