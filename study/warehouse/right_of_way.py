"""Who may enter which cell: priority inheritance with backtracking, asynchronous and iterative.

A robot holds the cell it leaves until it has arrived in the next, so two robots never hold the same
cell and disjoint cells keep bodies apart. A robot asks for its next cell when it stands, or half a
cell before the centre it is coming to. If a robot of lower priority stands in the wanted cell, that
one must make room first and inherits the right to push others (PIBT; Okumura et al. 2022, in its
form for robots that take their time). The method's promise needs a biconnected graph, so dead ends
are private: a bay may be entered by the robot that reserved it, a home by its owner.

Order of right: a robot leaving its bay or home, then whoever pursues its goal for longest; last
come robots whose way the human closes, so that others may push them aside.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from study.warehouse.halls import CELL_M
from study.warehouse.kernels import kernel
from study.warehouse.planning import Records, human_allows, refresh_plan
from study.warehouse.routes import SHARED, SOLID, neighbour_offset
from study.warehouse.state import (
    FORWARD,
    RETURNING,
    STANDING,
    TO_SHELF,
    TO_STATION,
    Record,
    Routes,
)

WINDOW_M = 0.3
"""A robot asks for its next cell from this distance before a centre on..."""
LEAST_TURN_M = 0.1
"""... to this one; later it is too late to round the corner, and it stops there first."""
AGENT, TRIED, COUNT, FIRST = range(4)


@kernel
def is_moving(r: Record) -> bool:
    """Say whether the robot has a goal to drive to."""
    return bool(r.state == TO_SHELF or r.state == TO_STATION or r.state == RETURNING)


@kernel
def may_ask(r: Record, fields: npt.NDArray[np.int16]) -> bool:
    """Say whether the robot needs its next cell now."""
    if r.next >= 0 or not is_moving(r):
        return False
    if r.mode == FORWARD:
        if r.stuck > 0 or not LEAST_TURN_M <= CELL_M - r.s <= WINDOW_M:
            return False
    elif r.mode != STANDING:
        return False
    return bool(fields[r.goal, r.head] != 0)


@kernel
def may_enter(trial: Record, cells: Records, distance: int, start: int, cell: int) -> bool:
    """Say whether a robot may go from `start` to its neighbour `cell`, `distance` from its goal.

    A bay or home is entered only by the robot whose goal it is.
    """
    kind = cells[cell].kind
    if kind == SOLID or (kind != SHARED and distance != 0):
        return False
    return human_allows(trial, cells, start, cell)


@kernel
def list_candidates(
    trial: Record,
    cells: Records,
    routes: Routes,
    r: Record,
    pusher: int,
    frame: npt.NDArray[np.int32],
    stride: int,
) -> None:
    """Write the cells that the robot would take, best first, to its frame of the stack.

    First the planned one, then others nearer to the goal; a robot that is pushed from the cell
    `pusher` (-1: it is not) also takes those farther from it, to the side before straight away:
    else it would be driven along before the other. A robot that is not pushed stays on its detour.
    """
    start = r.head
    away = start + start - pusher
    field = routes.fields[r.goal]
    plan = routes.plans[r.index]
    count = 0
    planned = -1
    if r.plan_at + 1 < r.plan_length and plan[r.plan_at] == start:
        planned = plan[r.plan_at + 1]
        if planned != r.tail and may_enter(trial, cells, field[planned], start, planned):
            frame[FIRST] = planned
            count = 1
    rounds = 3 if pusher >= 0 else 1 - r.detour
    for n in range(rounds):
        for d in range(4):
            cell = start + neighbour_offset(d, stride)
            rank = 0 if field[cell] < field[start] else (2 if cell == away else 1)
            if cell == planned or cell == r.tail or rank != n:
                continue
            if may_enter(trial, cells, field[cell], start, cell):
                frame[FIRST + count] = cell
                count += 1
    frame[AGENT] = r.index
    frame[TRIED] = 0
    frame[COUNT] = count
    r.decided = trial.tick


@kernel
def claim(cells: Records, plans: npt.NDArray[np.int32], r: Record, cell: int) -> None:
    """Give `cell` to the robot: it starts towards it, or will go on there without stopping."""
    cells[cell].holder = r.index
    if r.mode == STANDING:
        r.head = cell
        r.mode = FORWARD
        r.s = 0.0
        r.turn_m = 0.0
        r.stuck = 0
    else:
        r.next = cell
        straight = cell - r.head == r.head - r.tail
        r.turn_m = 0.0 if straight else min(WINDOW_M, CELL_M - r.s)
    if r.plan_at + 1 < r.plan_length and plans[r.index, r.plan_at + 1] == cell:
        r.plan_at += 1
    else:
        r.replan = 1


@kernel
def ask(
    trial: Record,
    robots: Records,
    cells: Records,
    routes: Routes,
    stack: npt.NDArray[np.int32],
    robot: int,
    stride: int,
) -> None:
    """Let the robot claim a cell, pushing others of lower right out of its way where it must."""
    depth = 0
    list_candidates(trial, cells, routes, robots[robot], -1, stack[0], stride)
    while depth >= 0:
        frame = stack[depth]
        if frame[TRIED] >= frame[COUNT]:
            depth -= 1
            continue
        cell = frame[FIRST + frame[TRIED]]
        frame[TRIED] += 1
        holder = cells[cell].holder
        if holder < 0:
            claim(cells, routes.plans, robots[frame[AGENT]], cell)
            return
        other = robots[holder]
        if other.mode != STANDING:
            if other.tail == cell and other.mode == FORWARD and other.stuck == 0:
                return
            continue
        if other.decided == trial.tick or cells[cell].kind != SHARED or not is_moving(other):
            continue
        refresh_plan(trial, robots, cells, routes, other, stride)
        pusher = robots[frame[AGENT]].head
        depth += 1
        list_candidates(trial, cells, routes, other, pusher, stack[depth], stride)


@kernel
def settle(
    trial: Record,
    robots: Records,
    cells: Records,
    routes: Routes,
    stack: npt.NDArray[np.int32],
    order: npt.NDArray[np.int64],
    stride: int,
) -> None:
    """Let every robot that needs a cell ask for it, in the order of right."""
    count = 0
    for k in range(robots.size):
        r = robots[k]
        if not may_ask(r, routes.fields):
            continue
        refresh_plan(trial, robots, cells, routes, r, stride)
        rank = 1 + r.held_up
        if r.mode == STANDING and cells[r.tail].kind != SHARED:
            rank = 0
        key = (rank << 48) + (r.goal_tick << 16) + k
        n = count
        while n > 0 and order[n - 1] > key:
            order[n] = order[n - 1]
            n -= 1
        order[n] = key
        count += 1
    for n in range(count):
        robot = order[n] & 65535
        if robots[robot].decided != trial.tick:
            ask(trial, robots, cells, routes, stack, robot, stride)
