"""The discrete states of the AR agents: one agent per robot, one per drop station [paper].

The names of the variables and their values are the paper's; the borders between the values are
our choice (`Thresholds`). A state is one whole number, made from the values in the tables'
order, the first variable counting most: 144 states of a robot, 18 of a station. So a policy over
them is exactly a lookup table.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from study.ar.distances import human_distances
from study.ar.elements import Display
from study.ar.state_kernels import code_robots, code_stations
from study.ar.thresholds import Thresholds

if TYPE_CHECKING:
    from study.ar.situation import ObservedWorld

States = NDArray[np.int16]

ROBOT_VARIABLES: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "humanState": ("close", "moderate", "far"),
        "robotTaskState": ("picking", "dropping"),
        "robotRemainingTasks": ("few", "many"),
        "robotWaitingTime": ("short", "medium", "long"),
        "nearbyRobots": ("few", "many"),
        "nearbyRobotVizStatus": ("few", "many"),
    }
)
STATION_VARIABLES: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "humanState": ("close", "moderate", "far"),
        "robotsWaitingTimeDS": ("short", "medium", "long"),
        "nRobotsAtDropStation": ("few", "many"),
    }
)
ROBOT_STATES: tuple[str, ...] = tuple("/".join(v) for v in product(*ROBOT_VARIABLES.values()))
STATION_STATES: tuple[str, ...] = tuple("/".join(v) for v in product(*STATION_VARIABLES.values()))


def robot_states(world: ObservedWorld, previous: Display, thresholds: Thresholds) -> States:
    """The state of each robot's agent, 0 to 143, shape (robots,).

    `previous` is what was displayed after the previous decision: the agents' only look at the
    display, which is what makes their states influence one another at all.
    """
    distance_m, _ = human_distances(world)
    states = np.empty(len(distance_m), np.int16)
    code_robots(
        distance_m,
        world.robot_x_m,
        world.robot_y_m,
        world.robot_carrying,
        world.robot_remaining,
        world.robot_wait_s,
        np.frombuffer(previous.robots, np.uint8),
        (thresholds.close_m, thresholds.far_m, thresholds.medium_wait_s, thresholds.long_wait_s),
        (thresholds.nearby_m, thresholds.many_shown_share),
        (thresholds.many_tasks, thresholds.many_nearby),
        states,
    )
    return states


def station_states(world: ObservedWorld, thresholds: Thresholds) -> States:
    """The state of each station's agent, 0 to 17, shape (stations,)."""
    _, distance_m = human_distances(world)
    states = np.empty(len(distance_m), np.int16)
    code_stations(
        distance_m,
        world.robot_state,
        world.robot_station,
        world.robot_wait_s,
        (thresholds.close_m, thresholds.far_m, thresholds.medium_wait_s, thresholds.long_wait_s),
        thresholds.many_waiting,
        states,
    )
    return states
