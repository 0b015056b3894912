"""An independent look at a world: plain Python on positions, apart from the compiled code."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from study.warehouse.world import RobotState, World

ROBOT_RADIUS_M = 0.2
HUMAN_RADIUS_M = 0.3


def check_bodies(world: World) -> None:
    """Assert that no bodies overlap each other, a shelf or a wall, in the present state."""
    layout = world.layout
    human = (world.human_x_m, world.human_y_m)
    places = list(zip(world.robot_x_m.tolist(), world.robot_y_m.tolist(), strict=True))
    for k, place in enumerate(places):
        assert math.dist(place, human) >= ROBOT_RADIUS_M + HUMAN_RADIUS_M, (world.tick, k)
        for m in range(k):
            assert math.dist(place, places[m]) >= 2 * ROBOT_RADIUS_M, (world.tick, k, m)
        assert rectangle_gap_m(place, layout.shelves_m) >= ROBOT_RADIUS_M, (world.tick, k)
    assert rectangle_gap_m(human, layout.solids_m) >= HUMAN_RADIUS_M - 1e-9, (world.tick, human)


def rectangle_gap_m(place: tuple[float, float], rectangles: npt.NDArray[np.float64]) -> float:
    """Distance from a point to the nearest of some axis-aligned rectangles (x0, y0, x1, y1)."""
    x0, y0, x1, y1 = rectangles.T
    dx = np.maximum(np.maximum(x0 - place[0], place[0] - x1), 0.0)
    dy = np.maximum(np.maximum(y0 - place[1], place[1] - y1), 0.0)
    return float(np.hypot(dx, dy).min())


def cell_of(world: World, robot: int) -> tuple[int, int]:
    """The lattice cell in which a robot's centre lies."""
    x, y = world.robot_x_m[robot], world.robot_y_m[robot]
    return math.floor(x / 0.6), math.floor((y - 0.6) / 0.6)


def put_human(world: World, x_m: float, y_m: float) -> None:
    """Set the human down somewhere, against all rules; for setting scenes only."""
    world.motion.trial["x"], world.motion.trial["y"] = x_m, y_m


def states(world: World) -> list[RobotState]:
    """What every robot does."""
    return [RobotState(state) for state in world.robot_state.tolist()]
