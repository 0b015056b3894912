"""Compiled loops that turn quantities into the agents' states; see `study.ar.states`.

`field` holds the steps from the human to each cell of the shared grid, int32[H, W], -1 unreachable.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from study.warehouse.kernels import kernel

Floats = NDArray[np.float64]
Field = NDArray[np.int32]
Borders = tuple[float, float, float, float]

CELL_M = 0.6
FLOOR_Y_M = 0.6
FAR_AWAY_M = 1e9
"""Stands for unreachable: beyond every border."""

WAITING = 3
"""The value of RobotState.WAITING."""


@kernel
def three_classes(value: float, middle: float, high: float) -> int:
    """0 below `middle`, 1 below `high`, else 2."""
    if value < middle:
        return 0
    if value < high:
        return 1
    return 2


@kernel
def path_length_m(field: Field, x_m: float, y_m: float) -> float:
    """Lattice path length to a place; a bay or home lies one step behind its mouth."""
    height, width = field.shape
    i = int(np.floor(x_m / CELL_M))
    j = int(np.floor((y_m - FLOOR_Y_M) / CELL_M))
    inside_i = min(max(i, 0), width - 1)
    inside_j = min(max(j, 0), height - 1)
    steps = int(field[inside_j, inside_i])
    if steps < 0:
        return FAR_AWAY_M
    return float(CELL_M * (steps + abs(i - inside_i) + abs(j - inside_j)))


@kernel
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


@kernel
def code_robots(
    field: Field,
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
        human_m = path_length_m(field, x_m[robot], y_m[robot])
        state = three_classes(human_m, borders[0], borders[1])
        state = state * 2 + (1 if carrying[robot] >= 0 else 0)
        state = state * 2 + (1 if remaining[robot] >= many[0] else 0)
        state = state * 3 + three_classes(wait_s[robot], borders[2], borders[3])
        state = state * 2 + (1 if count >= many[1] else 0)
        state = state * 2 + (1 if elements > near[1] * 3 * count else 0)
        states[robot] = state


@kernel
def code_stations(
    field: Field,
    mouths: NDArray[np.int64],
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
        steps = field[mouths[station, 1], mouths[station, 0]]
        human_m = CELL_M * steps if steps >= 0 else FAR_AWAY_M
        state = three_classes(human_m, borders[0], borders[1])
        state = state * 3 + three_classes(longest_s, borders[2], borders[3])
        states[station] = state * 2 + (1 if waiting >= many_waiting else 0)
