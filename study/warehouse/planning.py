"""Each robot's planned path: the shortest one, and a way round a human who stands in it.

A plan starts with the cells that the robot holds and ends at its goal; `plan_at` is the last of
them that it holds. Plans know nothing of other robots: right of way is settled cell by cell in
`right_of_way`. A plan is made anew when the goal changes, when the robot was pushed off it, and
when the human is found standing in its next cells.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from study.warehouse.halls import CELL_M
from study.warehouse.kernels import kernel
from study.warehouse.routes import UNREACHED, WALL, descend, fill_marked, neighbour_offset
from study.warehouse.state import BACKWARD, FORWARD, STANDING, Record, Routes

Records = npt.NDArray[np.void]

ZONE2 = 0.59 * 0.59
"""A cell whose centre is nearer to the human than 0.59 m is closed: between two cells that are not,
the way keeps sqrt(0.59^2 - 0.3^2) = 0.508 m from the human, more than both radii together."""

STOP2 = 0.506 * 0.506
"""A robot halts rather than come nearer to the human than 0.506 m."""

LOOK_AHEAD_CELLS = 8
REPLAN_TICKS = 10
RETRY_TICKS = 30
REST_TICKS = 15
"""Only a human who has stayed within 0.3 m for so long is driven round. One who walks is let pass:
a robot that gives way to a walker coming after it is herded along, however far that leads."""

PINNED_TICKS = 45


@kernel
def human_gap2(trial: Record, cells: Records, cell: int) -> float:
    """Return the squared distance from the human to the centre of `cell`."""
    dx = cells[cell].x - trial.x
    dy = cells[cell].y - trial.y
    return float(dx * dx + dy * dy)


@kernel
def human_allows(trial: Record, cells: Records, start: int, end: int) -> bool:
    """Say whether a robot may go from cell `start` to its neighbour `end` past the human's body.

    A robot that the human came close to may only go to a cell farther from the human.
    """
    gap2 = human_gap2(trial, cells, end)
    if gap2 >= 1.5:
        return True
    if gap2 < ZONE2 and not gap2 > human_gap2(trial, cells, start):
        return False
    ux = cells[end].x - cells[start].x
    uy = cells[end].y - cells[start].y
    wx = trial.x - cells[start].x
    wy = trial.y - cells[start].y
    along = (wx * ux + wy * uy) / (CELL_M * CELL_M)
    if along <= 0.0:
        return True
    if along >= 1.0:
        return gap2 >= STOP2
    qx = wx - along * ux
    qy = wy - along * uy
    return bool(qx * qx + qy * qy >= STOP2)


@kernel
def meets_human(trial: Record, cells: Records, path: npt.NDArray[np.int32]) -> bool:
    """Say whether the human closes the path's first step, or stands in one of its further cells."""
    if path.size > 1 and not human_allows(trial, cells, path[0], path[1]):
        return True
    for n in range(2, path.size):
        dx = cells[path[n]].x - trial.x
        dy = cells[path[n]].y - trial.y
        if dx * dx + dy * dy < ZONE2:
            return True
    return False


@kernel
def held_cells(r: Record, queue: npt.NDArray[np.int32]) -> int:
    """Write the cells that the robot must pass anyway to the queue's start; return how many."""
    if r.mode == FORWARD:
        queue[0] = r.tail
        queue[1] = r.head
        if r.next >= 0:
            queue[2] = r.next
            return 3
        return 2
    if r.mode == BACKWARD:
        queue[0] = r.head
        queue[1] = r.tail
        return 2
    queue[0] = r.head
    return 1


@kernel
def heading_direction(r: Record, queue: npt.NDArray[np.int32], held: int, stride: int) -> int:
    """Return the direction 0..3 in which the robot reaches the last of its held cells."""
    if held > 1:
        step = queue[held - 1] - queue[held - 2]
        for d in range(4):
            if neighbour_offset(d, stride) == step:
                return d
    return int(((r.heading + 8192) & 65535) >> 14)


@kernel
def find_way_round(
    trial: Record, robots: Records, cells: Records, routes: Routes, r: Record, stride: int
) -> bool:
    """Fill the scratch field with ways to the goal round the human and robots that it pins."""
    held = held_cells(r, routes.queue)
    start = routes.queue[held - 1]
    field = routes.field
    for n in range(field.size):
        field[n] = WALL if routes.fields[r.goal, n] == WALL else UNREACHED
    for k in range(robots.size):
        other = robots[k]
        if k != r.index and other.stuck >= PINNED_TICKS:
            field[other.tail] = WALL
            field[other.head] = WALL
            if other.next >= 0:
                field[other.next] = WALL
    column = int((trial.x - cells[0].x) / CELL_M + 0.5)
    row = int((trial.y - cells[0].y) / CELL_M + 0.5)
    for j in range(row - 1, row + 2):
        for i in range(column - 1, column + 2):
            if human_gap2(trial, cells, j * stride + i) < ZONE2:
                field[j * stride + i] = WALL
    for d in range(4):
        cell = start + neighbour_offset(d, stride)
        if not human_allows(trial, cells, start, cell):
            field[cell] = WALL
    field[start] = UNREACHED
    fill_marked(stride, routes.goals[r.goal], field, routes.queue, start)
    return bool(field[start] < WALL)


@kernel
def write_plan(trial: Record, r: Record, routes: Routes, held: int, length: int) -> None:
    """Take the path in the queue as the plan; it is a new version unless only passed cells went."""
    plan = routes.plans[r.index]
    shift = r.plan_length - length
    same = shift >= 0 and r.plan_at - shift == held - 1
    for n in range(length):
        if same and plan[n + shift] != routes.queue[n]:
            same = False
    if not same:
        r.plan_version += 1
    for n in range(length):
        plan[n] = routes.queue[n]
    r.plan_length = length
    r.plan_at = held - 1
    r.plan_tick = trial.tick


@kernel
def drop_plan(r: Record) -> None:
    """Leave the robot without a plan: it has no goal."""
    if r.plan_length > 0:
        r.plan_version += 1
    r.plan_length = 0
    r.plan_at = 0
    r.detour = 0
    r.held_up = 0


@kernel
def replan(
    trial: Record, robots: Records, cells: Records, routes: Routes, r: Record, stride: int
) -> None:
    """Make the robot's plan anew: the shortest path, or a way round the human standing in it.

    A robot on a detour goes back to the shortest path only when no part of that is closed any more:
    else it would turn round as soon as the human is far enough, and again when it is near.
    """
    if r.goal < 0:
        drop_plan(r)
        return
    queue = routes.queue
    field = routes.fields[r.goal]
    ahead = queue.size if r.detour == 1 else LOOK_AHEAD_CELLS
    held = held_cells(r, queue)
    heading = heading_direction(r, queue, held, stride)
    path = queue[held - 1 : routes.plans.shape[1] - 1]
    count = descend(field, stride, path[0], heading, path)
    r.detour = 0
    r.held_up = 0
    if meets_human(trial, cells, path[: min(ahead + 1, count)]):
        at_rest = trial.rest_ticks >= REST_TICKS
        if at_rest and find_way_round(trial, robots, cells, routes, r, stride):
            r.detour = 1
            field = routes.field
        else:
            r.held_up = 1
        held_cells(r, queue)
        count = descend(field, stride, path[0], heading, path)
    write_plan(trial, r, routes, held, held - 1 + count)


@kernel
def refresh_plan(
    trial: Record, robots: Records, cells: Records, routes: Routes, r: Record, stride: int
) -> None:
    """Before the robot asks for its next cell: see whether its plan still holds."""
    age = trial.tick - r.plan_tick
    last = r.tail if r.mode == STANDING else r.head
    plan = routes.plans[r.index]
    if r.plan_length == 0 or plan[r.plan_at] != last or r.plan_at == r.plan_length - 1:
        stale = True
    else:
        end = min(r.plan_at + 1 + LOOK_AHEAD_CELLS, r.plan_length)
        if meets_human(trial, cells, plan[r.plan_at : end]):
            stale = age >= REPLAN_TICKS
        else:
            stale = (r.detour == 1 or r.held_up == 1) and age >= RETRY_TICKS
    if stale:
        replan(trial, robots, cells, routes, r, stride)
