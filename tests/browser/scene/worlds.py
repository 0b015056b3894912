"""Scripted worlds for pictures: a real hall, robots set by hand-like rules, displays of every kind.

Nothing moves here: the scene is shown at one moment, with the messages that a server would send.
"""

from __future__ import annotations

import functools
import math
import random
from collections import deque
from dataclasses import asdict, dataclass
from typing import Any

from study.warehouse.layout import PRESETS, Layout, build_layout

Cell = tuple[int, int]
LIVE, GHOST, RIBBON, BEADS = 1, 2, 4, 8
MINIMAP, ARROWS = 1, 2


@dataclass(frozen=True)
class Robot:
    """One robot at one moment: metres, radians, RobotState number, colour or -1, path cells."""

    x_m: float
    y_m: float
    heading: float
    state: int
    carrying: int
    corners: list[Cell]


def describe_hall(layout: Layout) -> dict[str, Any]:
    """Return the hall as the welcome message describes it."""
    return {
        "scale": layout.spec.name,
        "hall_width_m": layout.hall_width_m,
        "hall_height_m": layout.hall_height_m,
        "shelves_m": layout.shelves_m.tolist(),
        "box_seed": 5,
        "stations": [
            {
                "index": station.index,
                "center_m": list(station.center_m),
                "bays": [list(cell) for cell in station.bay_cells],
            }
            for station in layout.stations
        ],
        "homes": layout.homes.tolist(),
        "eye_height_m": 1.65,
    }


@functools.cache
def spread_distances(layout: Layout, goal: Cell) -> dict[Cell, int]:
    """Return the steps to a goal over the shared grid, by cell."""
    distances = {goal: 0}
    wave = deque([goal])
    while wave:
        i, j = wave.popleft()
        for a, b in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)):
            inside = 0 <= a < layout.width_cells and 0 <= b < layout.height_cells
            if inside and layout.free[b, a] and (a, b) not in distances:
                distances[a, b] = distances[i, j] + 1
                wave.append((a, b))
    return distances


def walk_path(layout: Layout, start: Cell, mouth: Cell, rng: random.Random) -> list[Cell]:
    """Return the cells of a shortest path, going straight on where that is as short."""
    field = spread_distances(layout, mouth)
    path = [start]
    step = rng.choice([(1, 0), (0, 1), (-1, 0), (0, -1)])
    while path[-1] != mouth:
        i, j = path[-1]
        steps = [step, (1, 0), (-1, 0), (0, 1), (0, -1)]
        for di, dj in steps:
            a, b = i + di, j + dj
            if field.get((a, b), len(field)) < field[i, j]:
                step = (di, dj)
                path.append((a, b))
                break
        else:
            raise ValueError(f"no way from {start} to {mouth}")
    return path


def keep_corners(path: list[Cell]) -> list[Cell]:
    """Return first cell, turning points and last cell."""
    inner = [
        b
        for a, b, c in zip(path, path[1:], path[2:], strict=False)
        if (b[0] - a[0], b[1] - a[1]) != (c[0] - b[0], c[1] - b[1])
    ]
    return [path[0], *inner, path[-1]]


TURNS = {(1, 0): 0.0, (0, 1): 1.5708, (-1, 0): 3.1416, (0, -1): -1.5708}


@dataclass(frozen=True)
class Eye:
    """Where a picture is taken from."""

    x_m: float
    y_m: float
    heading: float


def in_sight(layout: Layout, eye: Eye, cell: Cell) -> bool:
    """Whether a cell lies 2.5 to 9 m ahead with no rack between."""
    x, y = layout.cell_center_m(*cell)
    dx, dy = x - eye.x_m, y - eye.y_m
    far = math.hypot(dx, dy)
    turn = math.remainder(math.atan2(dy, dx) - eye.heading, math.tau)
    if not 2.5 < far < 9 or abs(turn) > 0.5:
        return False
    points = [(eye.x_m + dx * n / 40, eye.y_m + dy * n / 40) for n in range(41)]
    shelves = layout.shelves_m.tolist()
    return not any(
        x0 <= px <= x1 and y0 <= py <= y1 for px, py in points for x0, y0, x1, y1 in shelves
    )


def place_robots(layout: Layout, seed: int, eye: Eye) -> list[Robot]:
    """Set the robots: every fourth one waits in a bay, the others drive to stations or shelves.

    Four of those that drive are set in sight of the eye.
    """
    rng = random.Random(seed)
    free = [(int(i), int(j)) for j, i in zip(*layout.free.nonzero(), strict=True)]
    near = [cell for cell in free if in_sight(layout, eye, cell)]
    used_bays: list[Cell] = []
    robots = []
    for robot in range(layout.spec.robots):
        station = layout.stations[robot % 4]
        if robot % 4 == 1:
            bay = next(cell for cell in station.bay_cells if cell not in used_bays)
            used_bays.append(bay)
            x, y = layout.cell_center_m(*bay)
            robots.append(Robot(x, y, 1.5708 if bay[1] < 0 else -1.5708, 3, robot % 4, []))
            continue
        pool = near if robot in (0, 2, 4, 7) and near else free
        start = pool[rng.randrange(len(pool))]
        near = [c for c in near if max(abs(c[0] - start[0]), abs(c[1] - start[1])) > 1]
        if robot % 2 == 0:
            bay = next(cell for cell in station.bay_cells if cell not in used_bays)
            used_bays.append(bay)
            mouth = station.mouths[station.bay_cells.index(bay)]
            path = [*walk_path(layout, start, mouth, rng), bay]
            carrying = robot % 4
        else:
            path = walk_path(layout, start, free[rng.randrange(len(free))], rng)
            carrying = -1
        a, b = path[0], path[min(1, len(path) - 1)]
        x, y = layout.cell_center_m(*start)
        heading = TURNS.get((b[0] - a[0], b[1] - a[1]), 0.0)
        state = 2 if carrying >= 0 else 0
        robots.append(Robot(x, y, heading, state, carrying, keep_corners(path)))
    return robots


DISPLAYS: dict[str, tuple[int, int, int]] = {
    "none": (0, 0, 0),
    "arroch": (0, LIVE | GHOST | RIBBON, 0),
    "crmiar": (MINIMAP | ARROWS, RIBBON | BEADS, 0),
    "full": (0, LIVE | GHOST | RIBBON, 1),
    "everything": (MINIMAP | ARROWS, LIVE | GHOST | RIBBON | BEADS, 1),
    "trajectory": (0, RIBBON, 0),
    "live-location": (0, LIVE, 0),
    "transparent-avatar": (0, GHOST, 0),
    "balloon": (0, 0, 1),
    "minimap": (MINIMAP, 0, 0),
    "offscreen-arrows": (ARROWS, 0, 0),
    "path-beads": (0, BEADS, 0),
}


def choose_display(name: str, robots: list[Robot]) -> dict[str, Any]:
    """Return overlays, masks and balloons; `mixed` is what a learned policy might show."""
    if name == "mixed":
        masks = [
            LIVE | RIBBON if r.carrying >= 0 and r.corners else LIVE if r.state == 3 else 0
            for r in robots
        ]
        masks = [mask | (GHOST if n % 3 == 0 and mask else 0) for n, mask in enumerate(masks)]
        return {"overlays": 0, "robots": masks, "stations": [0, 1, 0, 0]}
    overlays, mask, balloon = DISPLAYS[name]
    return {"overlays": overlays, "robots": [mask] * len(robots), "stations": [balloon] * 4}


def build_world(scale: str, display: str, seed: int, eye: Eye) -> dict[str, Any]:
    """Return everything the picture page needs, as JSON values."""
    layout = build_layout(PRESETS[scale])
    robots = place_robots(layout, seed, eye)
    return {
        "hall": describe_hall(layout),
        "robots": [asdict(robot) for robot in robots],
        "display": choose_display(display, robots),
        "start_m": list(layout.human_start_m),
    }
