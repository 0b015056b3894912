"""The discrete states of the AR agents: one agent per robot, one per drop station [paper].

Variables, values and the numbering of states are described in `study.ar.state_names`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from study.ar.distances import human_field, station_mouths
from study.ar.elements import Display
from study.ar.state_kernels import code_robots, code_stations
from study.ar.thresholds import Thresholds

if TYPE_CHECKING:
    from study.ar.situation import ObservedWorld

States = NDArray[np.int16]


def robot_states(world: ObservedWorld, previous: Display, thresholds: Thresholds) -> States:
    """The state of each robot's agent, 0 to 143, shape (robots,).

    `previous` is what was displayed after the previous decision: the agents' only look at the
    display, which is what makes their states influence one another at all.
    """
    states = np.empty(len(world.robot_x_m), np.int16)
    code_robots(
        human_field(world),
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
    mouths = station_mouths(world.layout)
    states = np.empty(len(mouths), np.int16)
    code_stations(
        human_field(world),
        mouths,
        world.robot_state,
        world.robot_station,
        world.robot_wait_s,
        (thresholds.close_m, thresholds.far_m, thresholds.medium_wait_s, thresholds.long_wait_s),
        thresholds.many_waiting,
        states,
    )
    return states
