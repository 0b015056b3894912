"""The trace of a replay as a table: one row per body, five times a second."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from study.warehouse.halls import TICK_HZ

if TYPE_CHECKING:
    from study.ar.elements import Display
    from study.warehouse.world import World

TRACE_HEADER = (
    "tick",
    "time_s",
    "body",
    "x_m",
    "y_m",
    "heading_rad",
    "state",
    "carrying",
    "wait_s",
    "shown",
    "policy_would_show",
)
_TURN_RAD = 2 * math.pi / 65536


def trace_rows(world: World, shown: Display, wished: Display | None) -> Iterator[list[Any]]:
    """The person, then every robot, then every station; what does not apply is empty.

    `shown` and `policy_would_show` are elements added up: 1 robot itself, 2 transparent avatar,
    4 trajectory, 8 beads; of a station 1 balloon; in the person's row 1 minimap, 2 arrows.
    """
    from study.warehouse.world import RobotState

    time_s = round(world.tick / TICK_HZ, 3)
    yaw_rad = round(world.human_yaw * _TURN_RAD, 5)
    person = [world.tick, time_s, "person", round(world.human_x_m, 4), round(world.human_y_m, 4)]
    yield [*person, yaw_rad, "", "", "", shown.overlays, wished.overlays if wished else ""]
    waits = world.robot_wait_s
    for k in range(len(world.robot_x_m)):
        place = [round(float(world.robot_x_m[k]), 4), round(float(world.robot_y_m[k]), 4)]
        state = RobotState(int(world.robot_state[k])).name.lower()
        carrying = int(world.robot_carrying[k])
        yield [
            *(world.tick, time_s, f"robot-{k}", *place),
            round(int(world.robot_heading[k]) * _TURN_RAD, 5),
            *(state, carrying if carrying >= 0 else "", round(float(waits[k]), 3)),
            *(shown.robots[k], wished.robots[k] if wished else ""),
        ]
    for station in world.layout.stations:
        k = station.index
        place = [round(float(v), 4) for v in station.center_m]
        balloons = [shown.stations[k], wished.stations[k] if wished else ""]
        yield [world.tick, time_s, f"station-{k}", *place, "", "", "", "", *balloons]
