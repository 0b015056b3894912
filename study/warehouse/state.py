"""The arrays that a compiled step reads and writes: the fixed floor, and a trial's whole state.

Every number that can change during a trial is in `Motion`'s state part, and `hash_state` covers
all of it. Cells are padded lattice indices (see `routes`), times are ticks of 1/30 s, -1 means
none.
"""

from __future__ import annotations

import functools
import hashlib
import math
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from study.warehouse.halls import CELL_M, SHELF_CELLS, TICK_HZ
from study.warehouse.kinematics import trig_table
from study.warehouse.layout import Layout, solids_near_cells
from study.warehouse.routes import PAD, SHARED, UNREACHED, fill_field
from study.warehouse.tasks import Draws, PooledTasks, TaskSource


class RobotState(IntEnum):
    """What a robot does, in the order of its life."""

    TO_SHELF = 0
    PICKING = 1
    TO_STATION = 2
    WAITING = 3
    UNLOADING = 4
    RETURNING = 5
    HOME = 6


TO_SHELF, PICKING, TO_STATION, WAITING, UNLOADING, RETURNING, HOME_STATE = range(7)
STANDING, FORWARD, BACKWARD, CENTRING = range(4)
RUNNING, COMPLETED, TIMED_OUT = range(3)
STATUSES = ("running", "completed", "timed_out")
MOST_GOAL_CELLS = 2 * SHELF_CELLS
LONGEST_PLAN = 1024
EVENT_FIELDS = 4

HALL = np.dtype(
    [
        ("stride", "i4"), ("robots", "i4"), ("boxes", "i4"), ("bays", "i4"), ("shelves", "i4"),
        ("cap_ticks", "i4"), ("pick_ticks", "i4"), ("unload_ticks", "i4"), ("by_station", "i4"),
        ("robot_step_m", "f8"), ("human_step_m", "f8"), ("unload_m", "f8"),
    ],
    align=True,
)  # fmt: skip

TRIAL = np.dtype(
    [
        ("tick", "i4"), ("status", "i4"), ("delivered", "i4"), ("tasks_given", "i4"),
        ("home", "i4"), ("events", "i4"), ("legs", "i4"), ("still_ticks", "i4"), ("contact", "i4"),
        ("overlaps", "i4"), ("yaw", "u2"), ("x", "f8"), ("y", "f8"), ("path_m", "f8"),
        ("rest_x", "f8"), ("rest_y", "f8"), ("rest_ticks", "i4"),
    ],
    align=True,
)  # fmt: skip

ROBOT = np.dtype(
    [
        ("x", "f8"), ("y", "f8"), ("s", "f8"), ("turn_m", "f8"), ("path_m", "f8"),
        ("leg_path_m", "f8"), ("plan_version", "i8"),
        ("tail", "i4"), ("head", "i4"), ("next", "i4"), ("goal", "i4"), ("goal_tick", "i4"),
        ("timer", "i4"), ("shelf", "i4"), ("box", "i4"), ("bay", "i4"), ("remaining", "i4"),
        ("delivered", "i4"), ("wait_ticks", "i4"), ("waited_ticks", "i4"), ("done_tick", "i4"),
        ("plan_length", "i4"), ("plan_at", "i4"), ("plan_tick", "i4"), ("decided", "i4"),
        ("index", "i4"), ("stuck", "i4"), ("best", "i4"), ("stall", "i4"), ("longest_stall", "i4"),
        ("blocked", "i4"), ("leg_start", "i4"),
        ("heading", "u2"), ("state", "i1"), ("carrying", "i1"), ("station", "i1"), ("mode", "i1"),
        ("detour", "i1"), ("held_up", "i1"), ("replan", "i1"),
    ],
    align=True,
)  # fmt: skip

LEG = np.dtype(
    [
        ("robot", "i4"), ("state", "i4"), ("start", "i4"), ("end", "i4"), ("shelf", "i4"),
        ("box", "i4"), ("station", "i4"), ("path_m", "f8"),
    ],
    align=True,
)  # fmt: skip


CELL = np.dtype(
    [("x", "f8"), ("y", "f8"), ("kind", "i4"), ("holder", "i4")],
    align=True,
)  # fmt: skip

Record = Any
"""One row of a structured array: compiled code reads and writes its fields as attributes."""


class Floor(NamedTuple):
    """What never changes in a hall. C padded cells, G goals: shelves, then bays, then homes."""

    hall: npt.NDArray[np.void]  # [1] of HALL
    fields: npt.NDArray[np.int16]  # [G, C] steps to the goal
    goals: npt.NDArray[np.int32]  # [G, MOST_GOAL_CELLS] the goal's cells, -1 filled
    solids: npt.NDArray[np.float64]  # [n, 4]
    near_solids: npt.NDArray[np.int16]  # [C, m]
    cosines: npt.NDArray[np.float64]  # [4096]
    stations: npt.NDArray[np.float64]  # [S, 2] middle of the bays' mouths


class Motion(NamedTuple):
    """A trial's whole state (the first eight), then scratch that carries nothing between ticks."""

    trial: npt.NDArray[np.void]  # [1] of TRIAL
    robots: npt.NDArray[np.void]  # [N] of ROBOT
    cells: npt.NDArray[np.void]  # [C] of CELL: place, kind, and the robot that holds it
    bays: npt.NDArray[np.int16]  # [S * b] the robot that has a bay reserved
    plans: npt.NDArray[np.int32]  # [N, P] planned cells
    tasks: npt.NDArray[np.int32]  # [boxes_total, 2] (shelf, box)
    draws: npt.NDArray[np.uint64]  # [1]
    legs: npt.NDArray[np.void]  # [most legs] of LEG
    events: npt.NDArray[np.int32]  # [E, 4] kind, robot, two data
    field: npt.NDArray[np.int16]  # [C]
    queue: npt.NDArray[np.int32]  # [C]
    stack: npt.NDArray[np.int32]  # [N + 1, 8]
    order: npt.NDArray[np.int64]  # [N]
    others: npt.NDArray[np.float64]  # [N, 2]


class Routes(NamedTuple):
    """The part of both that planning needs."""

    fields: npt.NDArray[np.int16]
    goals: npt.NDArray[np.int32]
    plans: npt.NDArray[np.int32]
    field: npt.NDArray[np.int16]
    queue: npt.NDArray[np.int32]


def goal_cells(layout: Layout) -> npt.NDArray[np.int32]:
    """Return each goal's cells: a shelf is picked from the 3 cells below it or the 3 above it."""
    rows: list[list[int]] = []
    for i, j in layout.shelf_cells.tolist():
        sides = [(i + n, j + side) for side in (-1, 1) for n in range(SHELF_CELLS)]
        rows.append([layout.cell_index(*cell) for cell in sides if _is_shared(layout, cell)])
    bays = [cell for station in layout.stations for cell in station.bay_cells]
    homes = [(i, j) for i, j in layout.homes.tolist()]
    rows.extend([layout.cell_index(*cell)] for cell in [*bays, *homes])
    table = np.full((len(rows), MOST_GOAL_CELLS), -1, dtype=np.int32)
    for line, cells in zip(table, rows, strict=True):
        line[: len(cells)] = cells
    return table


def _is_shared(layout: Layout, cell: tuple[int, int]) -> bool:
    return bool(layout.kinds[layout.cell_index(*cell)] == SHARED)


@functools.lru_cache(maxsize=32)
def build_floor(layout: Layout) -> Floor:
    """Compute a hall's constant arrays, all read-only by convention; cached per layout."""
    spec = layout.spec
    hall = np.zeros(1, dtype=HALL)
    near_robot = spec.unload_rule == "near_robot"
    values: dict[str, float] = {
        "stride": layout.stride,
        "robots": spec.robots,
        "boxes": spec.boxes_per_robot,
        "bays": spec.bays_per_station,
        "shelves": len(layout.shelf_cells),
        "cap_ticks": math.ceil(spec.cap_s * TICK_HZ),
        "pick_ticks": max(1, round(spec.pick_s * TICK_HZ)),
        "unload_ticks": max(1, round(spec.unload_s * TICK_HZ)),
        "by_station": not near_robot,
        "robot_step_m": spec.robot_speed_mps / TICK_HZ,
        "human_step_m": spec.human_speed_mps / TICK_HZ,
        "unload_m": spec.unload_radius_m if near_robot else spec.unload_square_m / 2,
    }
    for name, value in values.items():
        hall[name] = value
    goals = goal_cells(layout)
    fields = np.empty((len(goals), layout.kinds.size), dtype=np.int16)
    queue = np.empty(layout.kinds.size, dtype=np.int32)
    for line, field in zip(goals, fields, strict=True):
        fill_field(layout.kinds, layout.stride, line[line >= 0], field, queue)
    middles = [
        np.mean([layout.cell_center_m(*cell) for cell in station.mouths], axis=0)
        for station in layout.stations
    ]
    return Floor(
        hall=hall,
        fields=fields,
        goals=goals,
        solids=layout.solids_m.copy(),
        near_solids=solids_near_cells(layout),
        cosines=trig_table().copy(),
        stations=np.array(middles),
    )


def new_cells(layout: Layout) -> npt.NDArray[np.void]:
    """Return the padded lattice's cells, [C] of CELL, held by nobody."""
    cells = np.zeros(layout.kinds.size, dtype=CELL)
    cells["x"] = 0.3 + CELL_M * (np.arange(cells.size) % layout.stride - PAD)
    cells["y"] = 0.9 + CELL_M * (np.arange(cells.size) // layout.stride - PAD)
    cells["kind"] = layout.kinds
    cells["holder"] = -1
    return cells


def new_motion(layout: Layout, seed: int, tasks: TaskSource | None = None) -> Motion:
    """Return the state before the first tick: robots at home, the human at its start."""
    spec, cells, robots = layout.spec, layout.kinds.size, layout.spec.robots
    drawn = (tasks or PooledTasks()).draw_tasks(layout, seed)
    stream = Draws(seed ^ 0x5DEECE66D)
    motion = Motion(
        trial=np.zeros(1, dtype=TRIAL),
        robots=np.zeros(robots, dtype=ROBOT),
        cells=new_cells(layout),
        bays=np.full(spec.stations * spec.bays_per_station, -1, dtype=np.int16),
        plans=np.zeros((robots, min(cells, LONGEST_PLAN)), dtype=np.int32),
        tasks=np.ascontiguousarray(drawn, dtype=np.int32),
        draws=np.array([stream.next()], dtype=np.uint64),
        legs=np.zeros(robots * (5 * spec.boxes_per_robot + 2), dtype=LEG),
        events=np.zeros((8 * robots + 8, EVENT_FIELDS), dtype=np.int32),
        field=np.full(cells, UNREACHED, dtype=np.int16),
        queue=np.zeros(cells, dtype=np.int32),
        stack=np.zeros((robots + 1, 8), dtype=np.int32),
        order=np.zeros(robots, dtype=np.int64),
        others=np.zeros((robots, 2), dtype=np.float64),
    )
    motion.trial["x"], motion.trial["y"] = layout.human_start_m
    fleet = motion.robots
    for name in ("next", "carrying", "station", "bay", "done_tick", "goal", "shelf", "box"):
        fleet[name] = -1
    fleet["decided"] = -1
    fleet["remaining"] = spec.boxes_per_robot
    fleet["heading"] = 32768
    for k, (i, j) in enumerate(layout.homes.tolist()):
        cell = layout.cell_index(i, j)
        fleet["tail"][k] = fleet["head"][k] = cell
        fleet["index"][k] = k
        fleet["x"][k], fleet["y"][k] = layout.cell_center_m(i, j)
        motion.cells["holder"][cell] = k
    return motion


def hash_state(motion: Motion) -> bytes:
    """Return 8 bytes that stand for every bit of the state (blake2b)."""
    digest = hashlib.blake2b(digest_size=8)
    for array in (motion.trial, motion.robots, motion.bays, motion.tasks, motion.draws):
        digest.update(array.tobytes())
    digest.update(motion.cells["holder"].tobytes())
    digest.update(motion.legs[: int(motion.trial["legs"][0])].tobytes())
    for length, plan in zip(motion.robots["plan_length"].tolist(), motion.plans, strict=True):
        digest.update(plan[:length].tobytes())
    return digest.digest()
