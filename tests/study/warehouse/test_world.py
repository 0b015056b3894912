"""Promises of a world, held against what any person might do in it."""

from __future__ import annotations

import itertools
import math
from collections import Counter

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings

from study.people.patrols import Patrol
from study.warehouse.layout import PRESETS, HallSpec, build_layout
from study.warehouse.world import RobotState, World, WorldEvent
from tests.strategies import Script, hall_specs, input_scripts, seeds
from tests.study.warehouse.bodies import cell_of, check_bodies

SLOW = settings(max_examples=12, deadline=None, suppress_health_check=[HealthCheck.too_slow])


def play(world: World, script: Script) -> list[WorldEvent]:
    """Step a world through a script, checking bodies at every tick; return all events."""
    events = []
    for ticks, keys, yaw in script:
        for _ in range(ticks):
            events += world.step([(keys, yaw)])
            check_bodies(world)
    return events


@SLOW
@given(hall_specs(), seeds(), input_scripts())
def test_bodies_never_overlap(spec: HallSpec, seed: int, script: Script) -> None:
    """Guards bodies against each other, shelves and walls while somebody walks about at random."""
    play(World(build_layout(spec), seed), script)


@SLOW
@given(hall_specs(), seeds())
def test_bodies_never_overlap_when_chased(spec: HallSpec, seed: int) -> None:
    """Guards the same while somebody runs straight at the nearest robot, three frames a tick."""
    world = World(build_layout(spec), seed)
    for tick in range(900):
        x, y = world.robot_x_m - world.human_x_m, world.robot_y_m - world.human_y_m
        moving = np.isin(world.robot_state, (0, 2, 5))
        nearest = int(np.argmin(np.hypot(x, y) + 100.0 * ~moving))
        yaw = int(math.atan2(y[nearest], x[nearest]) / math.tau * 65536) & 65535
        world.step([(1, yaw)] * (1 + tick % 3))
        check_bodies(world)


@SLOW
@given(hall_specs(), seeds())
def test_every_box_is_delivered_exactly_once(spec: HallSpec, seed: int) -> None:
    """Guards whole trials: each box comes to a right station once, and all robots get home."""
    world = World(build_layout(spec), seed)
    patrol = Patrol("wanderer", world.floor, world.motion, seed)
    carried: dict[int, tuple[int, int]] = {}
    delivered: Counter[tuple[int, int]] = Counter()
    while world.status == "running":
        for event in world.step([patrol.next_frame()]):
            if event.kind == "leg_started" and event.robot is not None:
                carried[event.robot] = (int(event.data["shelf"]), int(event.data["box"]))
            if event.kind == "box_delivered" and event.robot is not None:
                box = carried.pop(event.robot)
                delivered[box] += 1
                colour = box[1] % 4 % spec.stations
                assert event.data["station"] in (colour, (colour + 1) % spec.stations)
        check_reservations(world)
    assert world.status == "completed"
    assert set(delivered.values()) == {1}
    assert set(delivered) == {tuple(task) for task in world.motion.tasks.tolist()}
    assert world.measures().boxes_delivered == world.boxes_delivered == spec.boxes_total


def check_reservations(world: World) -> None:
    """Assert that every bound robot has one bay of its own at its station, and no more exist."""
    bays = world.layout.spec.bays_per_station
    held = {int(k): n // bays for n, k in enumerate(world.motion.bays.tolist()) if k >= 0}
    assert len(held) == (world.motion.bays >= 0).sum(), "a robot holds two bays"
    for k, station in enumerate(world.robot_station.tolist()):
        if station >= 0:
            assert held[k] == station


def test_clocks_run_forward_and_add_up() -> None:
    """Guards that no clock runs backwards and that legs tile each robot's trial without gaps."""
    world = World(build_layout(PRESETS["small"]), 5)
    patrol = Patrol("cyclic", world.floor, world.motion, 5)
    before = world.motion.robots.copy()
    while world.status == "running":
        world.step([patrol.next_frame()])
        now = world.motion.robots
        for clock in ("waited_ticks", "longest_stall", "blocked", "path_m", "plan_version"):
            assert (now[clock] >= before[clock]).all(), clock
        before = now.copy()
    measures = world.measures()
    for robot, legs in itertools.groupby(measures.legs, key=lambda leg: leg.robot):
        stretch = list(legs)
        assert stretch[0].start_s == 0
        assert all(a.end_s == b.start_s for a, b in itertools.pairwise(stretch))
        own = measures.robots[robot]
        assert stretch[-1].end_s == own.completion_s
        waits = [leg.end_s - leg.start_s for leg in stretch if leg.state == "waiting"]
        # A robot served at its first tick in the bay has waited for no whole tick.
        assert sum(waits) == pytest.approx(own.wait_s, abs=len(waits) / 30 + 1e-3)
        assert sum(leg.path_m for leg in stretch) == pytest.approx(own.path_m, abs=1e-3)
        assert [leg.state for leg in stretch[:5]] == [
            "to_shelf",
            "picking",
            "to_station",
            "waiting",
            "unloading",
        ]
    assert measures.slowest_robot_s == max(r.completion_s for r in measures.robots)
    assert measures.sum_wait_s == pytest.approx(sum(r.wait_s for r in measures.robots))


def corners_of(path: list[list[int]]) -> list[list[int]]:
    """The first cell, every one where the path turns, the last."""
    return [
        [i, j]
        for n, (i, j) in enumerate(path)
        if n in (0, len(path) - 1)
        or (i - path[n - 1][0], j - path[n - 1][1]) != (path[n + 1][0] - i, path[n + 1][1] - j)
    ]


def test_planned_paths_lead_from_the_robot_to_its_goal() -> None:
    """Guards what the display draws: connected free cells, and a new version when they change."""
    world = World(build_layout(PRESETS["small"]), 8)
    patrol = Patrol("wanderer", world.floor, world.motion, 8)
    layout = world.layout
    old: dict[int, tuple[int, list[list[int]]]] = {}
    for _ in range(2500):
        world.step([patrol.next_frame()])
        for k in range(len(world.robot_x_m)):
            path = world.planned_path(k).tolist()
            assert world.planned_corners(k).tolist() == corners_of(path)
            version = int(world.plan_version[k])
            if world.robot_state[k] in (1, 3, 4, 6):
                assert path == []
                continue
            if k in old and old[k][0] == version:
                assert old[k][1][len(old[k][1]) - len(path) :] == path
            old[k] = (version, path)
            assert all(abs(a - c) + abs(b - d) == 1 for (a, b), (c, d) in itertools.pairwise(path))
            for i, j in path[1:-1]:
                private = not (0 <= i < layout.width_cells and 0 <= j < layout.height_cells)
                assert private or layout.free[j, i]
            i, j = cell_of(world, k)
            assert abs(path[0][0] - i) + abs(path[0][1] - j) <= 1
            if world.robot_state[k] == RobotState.RETURNING:
                assert path[-1] == layout.homes[k].tolist()
            if world.robot_state[k] == RobotState.TO_STATION:
                assert tuple(path[-1]) in layout.stations[world.robot_station[k]].bay_cells


def test_robots_turn_visibly() -> None:
    """Guards smooth driving: no robot jumps, and none turns more than 30 degrees in a tick."""
    world = World(build_layout(PRESETS["small"]), 3)
    patrol = Patrol("cyclic", world.floor, world.motion, 3)
    before = (world.robot_x_m.copy(), world.robot_y_m.copy(), world.robot_heading.copy())
    while world.status == "running":
        world.step([patrol.next_frame()])
        step_m = np.hypot(world.robot_x_m - before[0], world.robot_y_m - before[1])
        assert step_m.max() <= 1.0 / 30 + 1e-9
        turned = (world.robot_heading - before[2]).astype(np.int16)
        assert np.abs(turned).max() <= 65536 // 12
        before = (world.robot_x_m.copy(), world.robot_y_m.copy(), world.robot_heading.copy())


def test_near_station_rule() -> None:
    """Guards the other unload rule: the whole station is served from its middle, and only there."""
    spec = HallSpec.from_json(PRESETS["small"].to_json() | {"unload_rule": "near_station"})
    world = World(build_layout(spec), 4)
    served_apart = False
    patrol = Patrol("cyclic", world.floor, world.motion, 4)
    for _ in range(6000):
        for event in world.step([patrol.next_frame()]):
            if event.kind == "unload_started" and event.robot is not None:
                station = world.layout.stations[int(event.data["station"])]
                xs = [world.layout.cell_center_m(*cell) for cell in station.mouths]
                middle = np.mean(xs, axis=0)
                assert abs(world.human_x_m - middle[0]) <= 1.25
                assert abs(world.human_y_m - middle[1]) <= 1.25
                gap = (world.robot_x_m[event.robot] - world.human_x_m, 0.0)
                served_apart |= abs(gap[0]) > 1.0
    assert world.boxes_delivered > 0
    assert served_apart


def test_unloading_is_latched() -> None:
    """Guards that a box which is being unloaded is delivered even if the human runs away."""
    world = World(build_layout(PRESETS["practice"]), 1)
    patrol = Patrol("wanderer", world.floor, world.motion, 1)
    while RobotState.UNLOADING not in world.robot_state.tolist():
        world.step([patrol.next_frame()])
    world.motion.trial["x"] = world.layout.human_start_m[0]
    world.motion.trial["y"] = world.layout.human_start_m[1]
    kinds = [event.kind for _ in range(16) for event in world.step([])]
    assert "box_delivered" in kinds


def test_trial_ends_at_its_cap() -> None:
    """Guards the cap: a trial nobody works on times out, and then stays as it is."""
    spec = HallSpec.from_json(PRESETS["practice"].to_json() | {"cap_s": 30})
    world = World(build_layout(spec), 1)
    events = [event for _ in range(900) for event in world.step([])]
    assert events[-1].kind == "trial_timed_out"
    assert (world.status, world.tick) == ("timed_out", 900)
    ended = world.state_hash()
    assert world.step([(1, 0)]) == []
    assert world.state_hash() == ended
    assert not world.measures().legs[-1].ended


def test_too_many_frames_are_refused() -> None:
    """Guards against a speed hack at the last door."""
    with pytest.raises(ValueError, match="at most 3"):
        World(build_layout(PRESETS["practice"]), 1).step([(1, 0)] * 4)


@settings(max_examples=6, deadline=None)
@given(hall_specs(), seeds(), input_scripts(12))
def test_same_inputs_give_same_bits(spec: HallSpec, seed: int, script: Script) -> None:
    """Guards determinism in one process: two worlds side by side agree at every tick."""
    one, two = World(build_layout(spec), seed), World(build_layout(spec), seed)
    for ticks, keys, yaw in script:
        for _ in range(ticks):
            one.step([(keys, yaw)])
            two.step([(keys, yaw)])
            assert one.state_hash() == two.state_hash()
    assert (
        World(build_layout(spec), seed + 1).state_hash()
        != World(build_layout(spec), seed).state_hash()
    )


def test_hash_sees_every_part_of_the_state() -> None:
    """Guards that no field of the state can change without changing the hash."""
    world = World(build_layout(PRESETS["practice"]), 1)
    for _ in range(200):
        world.step([(1, 9000)])
    assert world.motion.robots["plan_length"][0] > 0
    original = world.state_hash()
    for array in (world.motion.trial, world.motion.robots):
        for name in array.dtype.names:
            kept = array[name][0]
            array[name][0] = kept + 1
            assert world.state_hash() != original, name
            array[name][0] = kept
    for array in (world.motion.bays, world.motion.draws, world.motion.tasks, world.motion.plans):
        array.flat[0] += 1
        assert world.state_hash() != original
        array.flat[0] -= 1
    world.motion.cells["holder"][5] += 1
    assert world.state_hash() != original
