"""The variables of the AR agents' states, their values, and the name of every state [paper].

A state is one whole number, made from the values in the tables' order, the first variable
counting most: 144 states of a robot, 18 of a station. So a policy over them is exactly a lookup
table. The borders between the values are our choice (`study.ar.thresholds`).
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from types import MappingProxyType

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
