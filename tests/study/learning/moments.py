"""Worlds by hand for the tests of learning: what agents may know at a tick, not simulated."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from study.ar.elements import Display
from study.ar.situation import Situation
from study.warehouse.layout import PRESETS, build_layout

LAYOUT = build_layout(PRESETS["small"])
ROBOTS, STATIONS = 6, 4
AGENTS = (ROBOTS, STATIONS)
BLANK = Display.nothing(ROBOTS, STATIONS)


def moment(tick: int, state: Sequence[int] = (0,) * ROBOTS) -> Situation:
    """A world by hand: `state` of each robot; the waiting ones stand at station 1."""
    return Situation(
        layout=LAYOUT,
        tick=tick,
        human_x_m=6.0,
        human_y_m=1.0,
        robot_x_m=np.linspace(1.0, 11.0, ROBOTS),
        robot_y_m=np.full(ROBOTS, 2.0),
        robot_state=np.array(state, np.int8),
        robot_carrying=np.full(ROBOTS, -1, np.int8),
        robot_station=np.full(ROBOTS, 1, np.int8),
        robot_remaining=np.full(ROBOTS, 3, np.int64),
        robot_wait_s=np.zeros(ROBOTS),
    )


def busy_moment(tick: int) -> Situation:
    """Another one that looks different at each tick, and the same each time."""
    draws = np.random.default_rng(tick)
    world = moment(tick, draws.integers(0, 7, ROBOTS).tolist())
    world.robot_remaining[:] = draws.integers(0, 4, ROBOTS)
    world.robot_wait_s[:] = draws.uniform(0, 40, ROBOTS)
    world.robot_x_m[:] = draws.uniform(1, 11, ROBOTS)
    return world
