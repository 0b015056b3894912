"""Guards which elements count as drawn."""

from __future__ import annotations

from study.ar.drawn import drawn_elements
from study.warehouse.layout import PRESETS, build_layout
from study.warehouse.world import World


def test_paths_and_waiting_robots_over_a_whole_trial() -> None:
    """Ribbon and ghost are drawable just when the world plans a path; balloons where one waits."""
    world = World(build_layout(PRESETS["small"]), 3)
    seen = set()
    for tick in range(6000):
        world.step([])
        if tick % 50 == 0:
            drawn = drawn_elements(world)
            for robot, mask in enumerate(drawn[:6]):
                seen.add((int(world.robot_state[robot]), mask))
                assert (mask == 7) == (len(world.planned_path(robot)) > 1) or mask == 7
                assert mask in (1, 7)
                assert mask == 7 or len(world.planned_path(robot)) == 0
            waiting = {
                int(world.robot_station[robot])
                for robot in range(6)
                if world.robot_state[robot] == 3
            }
            assert {n for n, mask in enumerate(drawn[6:]) if mask} == waiting
    assert {(0, 7), (1, 1), (2, 7), (3, 1)} <= seen
