"""The task pool and the choice of stations."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from study.warehouse.layout import PRESETS, Layout, build_layout
from study.warehouse.tasks import (
    BrokenPromise,
    PooledTasks,
    Tasks,
    count_bound,
    examine_tasks,
    reserve_bay,
)
from tests.strategies import seeds


@settings(max_examples=25, deadline=None)
@given(seeds())
def test_pool_keeps_its_contract(seed: int) -> None:
    """Guards that no box is handed out twice and a seed always draws the same."""
    for name in ("practice", "study"):
        examine_tasks(PooledTasks(), build_layout(PRESETS[name]), seed)


def test_examination_finds_a_double_box() -> None:
    """Guards the examination itself."""

    class SameBox:
        def draw_tasks(self, layout: Layout, seed: int) -> Tasks:
            return np.zeros((layout.spec.boxes_total, 2), dtype=np.int32)

    with pytest.raises(BrokenPromise, match="twice"):
        examine_tasks(SameBox(), build_layout(PRESETS["study"]), 1)


def test_every_box_is_about_equally_likely() -> None:
    """Guards the shuffle against a bias: 3000 draws of 72 boxes, expected 41.7 each."""
    layout = build_layout(PRESETS["practice"])
    drawn = [tuple(PooledTasks().draw_tasks(layout, seed)[0].tolist()) for seed in range(3000)]
    counts = np.array([drawn.count((shelf, box)) for shelf in range(6) for box in range(12)])
    assert counts.sum() == 3000
    assert ((counts - 3000 / 72) ** 2 / (3000 / 72)).sum() < 130  # chi square, 71 d. f., p 1e-5


@settings(max_examples=50, deadline=None)
@given(st.integers(1, 12), st.lists(st.tuples(st.integers(0, 3), st.integers(0, 11)), max_size=80))
def test_a_station_is_never_full(robots: int, steps: list[tuple[int, int]]) -> None:
    """Guards the proof that b = (N + 1) // 2 bays suffice, whoever comes and goes, in any order."""
    bays = (robots + 1) // 2
    holders = np.full(4 * bays, -1, dtype=np.int16)
    stream = np.array([7], dtype=np.uint64)
    for colour, k in steps:
        robot = k % robots
        if (holders == robot).any():
            holders[holders == robot] = -1
            continue
        before = [count_bound(holders, s, bays) for s in (colour, (colour + 1) % 4)]
        bay = reserve_bay(holders, bays, colour, robot, stream)
        assert bay >= 0
        assert holders[bay] == robot
        assert bay // bays in (colour, (colour + 1) % 4)
        chosen = before[0] if bay // bays == colour else before[1]
        assert chosen == min(before)
