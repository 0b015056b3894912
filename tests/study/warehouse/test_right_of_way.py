"""Every deadlock that was ever met, and the human as an obstacle that nothing obliges to move."""

from __future__ import annotations

import math

import numpy as np
import pytest

from study.headless import simulate_trial
from study.people.patrols import Patrol
from study.warehouse.layout import PRESETS, build_layout
from study.warehouse.world import RobotState, World
from tests.study.warehouse.bodies import cell_of, check_bodies, put_human, states

STATES_AT_REST = (RobotState.WAITING, RobotState.HOME)


def run(world: World, seconds: float) -> None:
    """Let time pass while the human stands, checking bodies every second."""
    for tick in range(int(seconds * 30)):
        world.step([])
        if tick % 30 == 0:
            check_bodies(world)


def walk_until(world: World, wanted: RobotState, worker: str = "wanderer") -> int:
    """Let a worker run the world until some robot is in the wanted state; return that robot."""
    patrol = Patrol(worker, world.floor, world.motion, 1)
    while wanted not in states(world):
        world.step([patrol.next_frame()])
    return states(world).index(wanted)


@pytest.mark.parametrize("place", [(0.5, 0.5), (0.25, 0.3), (0.7, 0.6), (0.5, 0.02), (0.97, 0.5)])
def test_an_idle_human_stops_nobody_else(place: tuple[float, float]) -> None:
    """Guards against a person who never moves: all robots not at a closed door get to their bays.

    Regression: an idle human in an aisle, or before a bay, made robots wait for ever.
    """
    layout = build_layout(PRESETS["study"])
    world = World(layout, 11)
    free = np.argwhere(layout.free)
    wanted = np.array([place[1] * layout.height_cells, place[0] * layout.width_cells])
    j, i = free[np.argmin(((free - wanted) ** 2).sum(axis=1))]
    put_human(world, *layout.cell_center_m(int(i), int(j)))
    run(world, 120)
    blocked = world.motion.robots["blocked"] > 0
    at_rest = np.isin(world.robot_state, STATES_AT_REST)
    assert (at_rest | blocked).all()
    assert world.measures().longest_stall_s < 60


def test_a_human_before_a_bay_is_booked_as_such() -> None:
    """Guards `blocked_by_human_s`: time before a covered mouth is no stall, and ends with it."""
    world = World(build_layout(PRESETS["practice"]), 2)
    robot = walk_until(world, RobotState.UNLOADING)
    i, _ = cell_of(world, robot)
    station = world.layout.stations[int(world.robot_station[robot])]
    mouth = next(cell for cell in station.mouths if cell[0] == i)
    put_human(world, *world.layout.cell_center_m(*mouth))
    run(world, 100)
    measures = world.measures()
    assert measures.robots[robot].blocked_by_human_s > 95
    assert measures.longest_stall_s < 10
    put_human(world, *world.layout.human_start_m)
    run(world, 60)
    assert world.status == "completed"


def test_a_bay_is_free_only_when_its_robot_has_left() -> None:
    """Regression: a bay freed at once let the next robot stand in the leaver's way."""
    world = World(build_layout(PRESETS["small"]), 9)
    patrol = Patrol("cyclic", world.floor, world.motion, 9)
    height = world.layout.height_cells
    while world.status == "running":
        world.step([patrol.next_frame()])
        for k in range(len(world.robot_x_m)):
            _, j = cell_of(world, k)
            if j in (-1, height):
                assert (world.motion.bays == k).sum() == 1


def test_private_cells_are_entered_by_their_owner_only() -> None:
    """Regression: a robot pushed into another one's bay locked both."""
    world = World(build_layout(PRESETS["small"]), 10)
    layout = world.layout
    bays = [cell for station in layout.stations for cell in station.bay_cells]
    homes = [tuple(home) for home in layout.homes.tolist()]
    patrol = Patrol("blocker", world.floor, world.motion, 10)
    while world.status == "running":
        world.step([patrol.next_frame()])
        for k in range(len(world.robot_x_m)):
            cell = cell_of(world, k)
            if cell in bays:
                assert world.motion.bays[bays.index(cell)] == k
            if cell in homes:
                assert homes.index(cell) == k


def drive_mid_edge(world: World) -> int:
    """Let the first robot drive out to the middle of a straight edge; return its index."""
    robots = world.motion.robots
    for _ in range(400):
        world.step([])
        r = robots[0]
        if r["next"] < 0 and 0.2 < r["s"] < 0.28 and world.layout.kinds[r["tail"]] == 1:
            return 0
    raise AssertionError("the robot never drove straight")


def test_a_robot_held_mid_edge_drives_back() -> None:
    """Regression: human and robot blocked each other between two cells. It backs off and goes
    round.
    """
    world = World(build_layout(PRESETS["practice"]), 3)
    robot = drive_mid_edge(world)
    heading = world.robot_heading[robot] / 65536 * math.tau
    ahead_m = 0.51
    put_human(
        world,
        world.robot_x_m[robot] + ahead_m * math.cos(heading),
        world.robot_y_m[robot] + ahead_m * math.sin(heading),
    )
    place = (float(world.robot_x_m[robot]), float(world.robot_y_m[robot]))
    run(world, 0.6)
    assert math.dist(place, (world.robot_x_m[robot], world.robot_y_m[robot])) < 0.01
    run(world, 40)
    assert world.measures().robots[robot].longest_stall_s < 20
    assert RobotState.TO_SHELF not in states(world)


def test_a_robot_near_the_human_only_moves_away() -> None:
    """Regression: a robot in the human's zone stepped towards the human and stuck."""
    world = World(build_layout(PRESETS["study"]), 4)
    for tick in range(2400):
        nearest = np.hypot(
            world.robot_x_m - world.human_x_m, world.robot_y_m - world.human_y_m
        ).min()
        before = np.hypot(world.robot_x_m - world.human_x_m, world.robot_y_m - world.human_y_m)
        world.step([(1, (tick // 45 * 9973) & 65535)] if tick % 90 < 45 else [])
        if tick % 90 >= 46:  # the human stands
            gap = np.hypot(world.robot_x_m - world.human_x_m, world.robot_y_m - world.human_y_m)
            close = gap < 0.5059
            assert (gap[close] >= before[close] - 1e-12).all()
        assert nearest >= 0.5


@pytest.mark.parametrize(("scale", "worker", "seed"), [
    ("large", "wanderer", 103), ("large", "blocker", 106), ("study", "cyclic", 122),
    ("lab", "wanderer", 118), ("small", "wanderer", 123),
        ("large", "blocker", 9087),
        ("large", "blocker", 9104),
])  # fmt: skip
def test_hard_seeds_go_well(scale: str, worker: str, seed: int) -> None:
    """Regressions: a pushed robot was driven backwards along a wall for 94 s; a robot whose first
    step the human closed did not look for a way round; a worker pressed into a parked robot.
    """
    measures = simulate_trial(build_layout(PRESETS[scale]), seed, worker).measures
    assert measures.status == "completed"
    assert measures.longest_stall_s < 30
    assert measures.overlaps == 0
