"""A closed-loop driver: reads position and heading off the page and presses real keys.

It knows what a participant could know (the hall and what is in front of them) through the `data-`
attributes which every build carries, so it works at any frame rate.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from itertools import pairwise

from playwright.sync_api import Error, Page

from study.warehouse.layout import Layout
from study.warehouse.world import RobotState

CELL_M = 0.6
REACHED_M = 0.3
ARRIVED_M = 0.1
ASIDE_M = 1.5
STANDSTILL_S = 60.0
KEY_DIRECTIONS = {  # forward and left parts of the motion, relative to the view
    ("w",): (1, 0), ("s",): (-1, 0), ("a",): (0, 1), ("d",): (0, -1),
    ("w", "a"): (1, 1), ("w", "d"): (1, -1), ("s", "a"): (-1, 1), ("s", "d"): (-1, -1),
}  # fmt: skip


@dataclass(frozen=True)
class Reading:
    """What the page says about the world at one moment; metres and radians."""

    phase: str
    tick: int
    x_m: float
    y_m: float
    yaw_rad: float
    boxes_delivered: int
    connection: str
    robots: tuple[tuple[float, float, RobotState], ...]


def read(page: Page) -> Reading | None:
    """The page's reading, or None where no trial is on screen."""
    try:
        data = page.evaluate("() => ({...document.querySelector('#stage')?.dataset})")
    except Error as problem:
        if "context was destroyed" not in problem.message:
            raise
        return None  # the page is just leaving for the next one
    if "tick" not in data or "robots" not in data or not data["robots"]:
        return None
    robots = []
    for part in data["robots"].split(";"):
        x, y, state = part.split(":")[1].split(",")
        robots.append((float(x), float(y), RobotState(int(state))))
    return Reading(
        phase=data["phase"],
        tick=int(data["tick"]),
        x_m=float(data["xM"]),
        y_m=float(data["yM"]),
        yaw_rad=int(data["yaw"]) / 65536 * 2 * math.pi,
        boxes_delivered=int(data["boxesDelivered"]),
        connection=data["connection"],
        robots=tuple(robots),
    )


class Driver:
    """Serves every waiting robot of one trial, then lets go of the keys."""

    def __init__(self, page: Page, layout: Layout) -> None:
        self.page = page
        self.layout = layout
        self.held: tuple[str, ...] = ()
        self.unloads_seen = 0

    def play(self, timeout_s: float) -> None:
        """Play until the page leaves the trial; every decision follows from the last reading.

        Raises:
            AssertionError: nothing was delivered for `timeout_s` of the world's time, or that
                time stood still for a minute.
        """
        last_progress_tick, delivered = 0, 0
        last_tick, moved_s = -1, time.monotonic()
        while (reading := read(self.page)) is not None and reading.phase != "finished":
            if reading.boxes_delivered > delivered:
                last_progress_tick, delivered = reading.tick, reading.boxes_delivered
            if reading.tick != last_tick:
                last_tick, moved_s = reading.tick, time.monotonic()
            assert time.monotonic() - moved_s < STANDSTILL_S, f"the world stands still: {reading}"
            self.unloads_seen = max(self.unloads_seen, reading.boxes_delivered)
            assert (reading.tick - last_progress_tick) / 30 < timeout_s, f"no progress: {reading}"
            self.hold(self.keys_for(reading) if reading.phase == "running" else ())
            self.page.wait_for_timeout(30)
        self.hold(())

    def keys_for(self, reading: Reading) -> tuple[str, ...]:
        """Keys that lead to the nearest waiting robot; with nobody to serve, out of others' way."""
        waiting = [
            (math.dist((x, y), (reading.x_m, reading.y_m)), x, y)
            for x, y, state in reading.robots
            if state is RobotState.WAITING
        ]
        if waiting:
            _, x, y = min(waiting)
            goal = self.cell_beside(x, y)
        elif any(
            math.dist((x, y), (reading.x_m, reading.y_m)) < ASIDE_M for x, y, _ in reading.robots
        ):
            goal = self.cell_of(*self.layout.human_start_m)
        else:
            return ()
        waypoint = self.next_waypoint(reading, goal)
        if waypoint is None:
            return ()
        wish = math.atan2(waypoint[1] - reading.y_m, waypoint[0] - reading.x_m) - reading.yaw_rad
        return max(
            KEY_DIRECTIONS,
            key=lambda keys: math.cos(
                wish - math.atan2(KEY_DIRECTIONS[keys][1], KEY_DIRECTIONS[keys][0])
            ),
        )

    def cell_of(self, x_m: float, y_m: float) -> tuple[int, int]:
        """The shared cell nearest to a place; a place in a bay gives the bay's mouth."""
        column = round((x_m - 0.3) / CELL_M)
        row = round((y_m - 0.9) / CELL_M)
        return (
            min(max(column, 0), self.layout.width_cells - 1),
            min(max(row, 0), self.layout.height_cells - 1),
        )

    def cell_beside(self, x_m: float, y_m: float) -> tuple[int, int]:
        """The cell next to a bay's mouth: near enough to unload, out of the leaving robot's way."""
        column, row = self.cell_of(x_m, y_m)
        return column + (1 if column < self.layout.width_cells / 2 else -1), row

    def next_waypoint(self, reading: Reading, goal: tuple[int, int]) -> tuple[float, float] | None:
        """Centre of the farthest cell ahead on the shortest path that is in a straight line."""
        field = self.layout.distance_field(goal)
        path = [self.cell_of(reading.x_m, reading.y_m)]
        while field[path[-1][1], path[-1][0]] > 0:
            i, j = path[-1]
            steps = [(i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)]
            inside = [
                (a, b)
                for a, b in steps
                if 0 <= a < self.layout.width_cells
                and 0 <= b < self.layout.height_cells
                and field[b, a] >= 0
            ]
            path.append(min(inside, key=lambda cell: int(field[cell[1], cell[0]])))
        centres = [self.layout.cell_center_m(i, j) for i, j in path]
        if len(path) == 1:
            there = math.dist(centres[0], (reading.x_m, reading.y_m)) < ARRIVED_M
            return None if there else centres[0]
        straight = straight_run(path)
        off_line = lateral_error(reading, centres[0], centres[1])
        return centres[0] if off_line > REACHED_M else centres[straight]

    def hold(self, keys: tuple[str, ...]) -> None:
        """Hold exactly these keys down."""
        for key in self.held:
            if key not in keys:
                self.page.keyboard.up(key)
        for key in keys:
            if key not in self.held:
                self.page.keyboard.down(key)
        self.held = keys


def straight_run(path: list[tuple[int, int]]) -> int:
    """Index of the last cell before the path turns."""
    first = (path[1][0] - path[0][0], path[1][1] - path[0][1])
    for index, (a, b) in enumerate(pairwise(path)):
        if (b[0] - a[0], b[1] - a[1]) != first:
            return index
    return len(path) - 1


def lateral_error(
    reading: Reading, start: tuple[float, float], towards: tuple[float, float]
) -> float:
    """Distance in metres of the human from the line it should walk along."""
    return abs(reading.y_m - start[1]) if towards[1] == start[1] else abs(reading.x_m - start[0])
