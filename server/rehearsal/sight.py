"""What a simulated participant's page is sent of its trial, and the hall as it knows it.

Only what comes over the socket is used: the welcome, snapshots and what is displayed.
"""

from __future__ import annotations

import math
import struct
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

WAITING = 3
PER_M = 512.0
_HEAD = struct.Struct("<BBIHHHH")
_ROBOT = struct.Struct("<HHBB")
BODY_M = 0.29
STEPS = ((1, 0), (-1, 0), (0, 1), (0, -1))

Cell = tuple[int, int]
Field = dict[Cell, int]


class Robot(NamedTuple):
    """A robot as a snapshot shows it; places in metres."""

    x: float
    y: float
    state: int


class Sight(NamedTuple):
    """One snapshot."""

    tick: int
    x: float
    y: float
    robots: list[Robot]


def read_snapshot(data: bytes) -> Sight:
    """Read a binary snapshot."""
    _, _, tick, _, x, y, _ = _HEAD.unpack_from(data)
    robots = [
        Robot(rx / PER_M, ry / PER_M, state & 7)
        for rx, ry, _, state in _ROBOT.iter_unpack(data[_HEAD.size :])
    ]
    return Sight(tick, x / PER_M, y / PER_M, robots)


def read_display(data: bytes) -> tuple[bytes, bytes]:
    """What is shown: a mask per robot, 0 or 1 per station."""
    robots = data[2]
    return data[3 : 3 + robots], data[4 + robots :]


class Hall:
    """The floor that a person can walk on, as the welcome tells it."""

    def __init__(self, hall: Mapping[str, Any]) -> None:
        self.cell_m: float = hall["cell_m"]
        self.speed_mps: float = hall["human_speed_mps"]
        self.stations: list[tuple[float, float]] = [tuple(s["center_m"]) for s in hall["stations"]]
        solids = hall["solids_m"]
        self.free = {
            (i, j)
            for i in range(hall["width_cells"])
            for j in range(hall["height_cells"])
            if not any(_touches(self.center((i, j)), solid) for solid in solids)
        }
        self._fields: dict[Cell, Field] = {}

    def center(self, cell: Cell) -> tuple[float, float]:
        """The middle of a cell in metres."""
        return self.cell_m * (cell[0] + 0.5), self.cell_m * (cell[1] + 1.5)

    def cell_at(self, x: float, y: float) -> Cell:
        """The free cell whose middle is nearest to a place."""
        i, j = int(x / self.cell_m), int(y / self.cell_m - 1.0)
        for radius in (1, 3):
            near = [cell for cell in self._around((i, j), radius) if cell in self.free]
            if near:
                return min(near, key=lambda cell: math.dist(self.center(cell), (x, y)))
        return min(self.free, key=lambda cell: math.dist(self.center(cell), (x, y)))

    def field_to(self, goal: Cell) -> Field:
        """Steps to a cell from everywhere."""
        if goal not in self._fields:
            self._fields[goal] = self.spread(goal, self.free)
        return self._fields[goal]

    def spread(self, goal: Cell, open_cells: Iterable[Cell]) -> Field:
        """Steps to a cell from everywhere over these cells."""
        left = set(open_cells) | {goal}
        found = {goal: 0}
        edge = deque([goal])
        while edge:
            i, j = edge.popleft()
            for di, dj in STEPS:
                beside = (i + di, j + dj)
                if beside in left and beside not in found:
                    found[beside] = found[i, j] + 1
                    edge.append(beside)
        return found

    def _around(self, cell: Cell, radius: int) -> list[Cell]:
        span = range(-radius, radius + 1)
        return [(cell[0] + di, cell[1] + dj) for di in span for dj in span]


def next_cell(field: Field, cell: Cell) -> Cell:
    """The cell to head for: one step down, two where the way is straight."""
    step = _down(field, cell)
    further = _down(field, step)
    is_straight = (further[0] - step[0], further[1] - step[1]) == (
        step[0] - cell[0],
        step[1] - cell[1],
    )
    return further if is_straight else step


def _down(field: Field, cell: Cell) -> Cell:
    beside = [(cell[0] + di, cell[1] + dj) for di, dj in STEPS]
    lower = [c for c in beside if c in field and field[c] < field.get(cell, 1 << 30)]
    return min(lower, key=lambda c: field[c], default=cell)


def _touches(place: tuple[float, float], solid: Sequence[float]) -> bool:
    x = min(max(place[0], solid[0]), solid[2])
    y = min(max(place[1], solid[1]), solid[3])
    return math.dist(place, (x, y)) < BODY_M
