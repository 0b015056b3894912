"""Compiled loops that turn quantities into the agents' states; see `study.ar.states`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Borders = tuple[float, float, float, float]

WAITING = 3
"""The value of RobotState.WAITING."""


def three_classes(value: float, middle: float, high: float) -> int:
    """0 below `middle`, 1 below `high`, else 2."""
    if value < middle:
        return 0
    if value < high:
        return 1
    return 2


def neighbourhood(
    robot: int, x_m: Floats, y_m: Floats, shown: NDArray[np.uint8], nearby_m: float
) -> tuple[int, int]:
    """Number of other robots within `nearby_m`, and how many of their three elements show."""
    count, elements = 0, 0
    for other in range(len(x_m)):
        dx, dy = x_m[other] - x_m[robot], y_m[other] - y_m[robot]
        if other != robot and dx * dx + dy * dy <= nearby_m * nearby_m:
            mask = shown[other]
            count += 1
            elements += (mask & 1) + (mask >> 1 & 1) + (mask >> 2 & 1)
    return count, elements


def code_robots(
    distance_m: Floats,
    x_m: Floats,
    y_m: Floats,
    carrying: NDArray[np.int8],
    remaining: NDArray[np.int64],
    wait_s: Floats,
    shown: NDArray[np.uint8],
    borders: Borders,
    near: tuple[float, float],
    many: tuple[int, int],
    states: NDArray[np.int16],
) -> None:
    """Fill `states`: `borders` close, far, medium, long; `near` radius, share; `many` counts."""
    for robot in range(len(states)):
        count, elements = neighbourhood(robot, x_m, y_m, shown, near[0])
        state = three_classes(distance_m[robot], borders[0], borders[1])
        state = state * 2 + (1 if carrying[robot] >= 0 else 0)
        state = state * 2 + (1 if remaining[robot] >= many[0] else 0)
        state = state * 3 + three_classes(wait_s[robot], borders[2], borders[3])
        state = state * 2 + (1 if count >= many[1] else 0)
        state = state * 2 + (1 if elements > near[1] * 3 * count else 0)
        states[robot] = state


def code_stations(
    distance_m: Floats,
    robot_state: NDArray[np.int8],
    robot_station: NDArray[np.int8],
    wait_s: Floats,
    borders: Borders,
    many_waiting: int,
    states: NDArray[np.int16],
) -> None:
    """Fill `states` of the stations from the robots that wait at each."""
    for station in range(len(states)):
        waiting, longest_s = 0, 0.0
        for robot in range(len(wait_s)):
            if robot_state[robot] == WAITING and robot_station[robot] == station:
                waiting += 1
                longest_s = max(longest_s, wait_s[robot])
        state = three_classes(distance_m[station], borders[0], borders[1])
        state = state * 3 + three_classes(longest_s, borders[2], borders[3])
        states[station] = state * 2 + (1 if waiting >= many_waiting else 0)
