"""A policy's two tables as matrices that a person can read, alone or beside another policy's.

Rows and columns are the states' variables in the order of `study.ar.state_names`, taken apart:
a robot's task, remaining tasks and the human's distance go down, the rest across.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from math import prod

from study.ar.elements import Element
from study.ar.state_names import ROBOT_STATES, ROBOT_VARIABLES, STATION_STATES, STATION_VARIABLES
from study.learning.policy import Policy


@dataclass(frozen=True)
class Mark:
    """What one bit of an action stands for."""

    bit: int
    letter: str
    name: str


ROBOT_MARKS = (
    Mark(Element.TRAJECTORY, "T", "trajectory"),
    Mark(Element.LIVE_LOCATION, "L", "live location"),
    Mark(Element.TRANSPARENT_AVATAR, "A", "transparent avatar"),
)
STATION_MARKS = (Mark(1, "B", "balloon"),)
_NAMES = {
    "humanState": "human",
    "robotTaskState": "task",
    "robotRemainingTasks": "tasks left",
    "robotWaitingTime": "waiting",
    "nearbyRobots": "robots nearby",
    "nearbyRobotVizStatus": "shown nearby",
    "robotsWaitingTimeDS": "longest wait",
    "nRobotsAtDropStation": "robots waiting",
}


@dataclass(frozen=True)
class Cell:
    """One state: its name, the action, and the other policy's where that differs."""

    state: str
    action: int
    other: int | None


@dataclass(frozen=True)
class Matrix:
    """`head`: header rows of (text, columns spanned); `rows`: the values of the row, its cells."""

    title: str
    marks: tuple[Mark, ...]
    row_names: tuple[str, ...]
    head: tuple[tuple[str, tuple[tuple[str, int], ...]], ...]
    rows: tuple[tuple[tuple[str, ...], tuple[Cell, ...]], ...]

    @property
    def states(self) -> int:
        """How many states it shows."""
        return sum(len(cells) for _, cells in self.rows)

    @property
    def differing(self) -> int:
        """In how many states the other policy acts otherwise."""
        return sum(cell.other is not None for _, cells in self.rows for cell in cells)


def lay_out_policy(policy: Policy, other: Policy | None) -> tuple[Matrix, Matrix]:
    """The matrices of robots and stations, compared with the other policy if there is one."""
    robots = _Layout(
        "Robots",
        ROBOT_MARKS,
        ("robotTaskState", "robotRemainingTasks", "humanState"),
        ("robotWaitingTime", "nearbyRobots", "nearbyRobotVizStatus"),
    )
    stations = _Layout(
        "Stations",
        STATION_MARKS,
        ("humanState",),
        ("robotsWaitingTimeDS", "nRobotsAtDropStation"),
    )
    return (
        robots.fill(ROBOT_STATES, policy.robot_table, other.robot_table if other else None),
        stations.fill(STATION_STATES, policy.station_table, other.station_table if other else None),
    )


@dataclass(frozen=True)
class _Layout:
    title: str
    marks: tuple[Mark, ...]
    down: tuple[str, ...]
    across: tuple[str, ...]

    def fill(
        self, states: Sequence[str], table: Sequence[int], other: Sequence[int] | None
    ) -> Matrix:
        """Put each state's action into its place."""
        variables = ROBOT_VARIABLES if len(states) == len(ROBOT_STATES) else STATION_VARIABLES
        columns = tuple(product(*(variables[name] for name in self.across)))
        rows = []
        for row in product(*(variables[name] for name in self.down)):
            cells = []
            for column in columns:
                chosen = dict(zip((*self.down, *self.across), (*row, *column), strict=True))
                state = "/".join(chosen[name] for name in variables)
                at = states.index(state)
                theirs = other[at] if other is not None and other[at] != table[at] else None
                cells.append(Cell(state, table[at], theirs))
            rows.append((row, tuple(cells)))
        head = []
        for level, name in enumerate(self.across):
            span = len(columns) // prod(len(variables[n]) for n in self.across[: level + 1])
            texts = [column[level] for column in columns[::span]]
            head.append((_NAMES[name], tuple((text, span) for text in texts)))
        names = tuple(_NAMES[name] for name in self.down)
        return Matrix(self.title, self.marks, names, tuple(head), tuple(rows))
