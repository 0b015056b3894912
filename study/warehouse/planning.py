"""Each robot's planned path: the shortest one, and a way round a human who stands in it.

A plan starts with the cells that the robot holds and ends at its goal; `plan_at` is the last of
them that it holds. Plans know nothing of other robots: right of way is settled cell by cell in
`right_of_way`. A plan is made anew when the goal changes, when the robot was pushed off it, and
when the human is found standing in its next cells.
"""

from __future__ import annotations

from study.warehouse.halls import CELL_M
from study.warehouse.kernels import kernel
from study.warehouse.routes import UNREACHED, descend, fill_marked, neighbour_offset
from study.warehouse.state import BACKWARD, FORWARD, STANDING, Floor, Motion

ZONE2 = 0.59 * 0.59
"""A cell whose centre is nearer to the human than 0.59 m is closed: between two cells that are not,
the way keeps sqrt(0.59^2 - 0.3^2) = 0.508 m from the human, more than both radii together."""

STOP2 = 0.506 * 0.506
"""A robot halts rather than come nearer to the human than 0.506 m."""

LOOK_AHEAD_CELLS = 8
REPLAN_TICKS = 10
RETRY_TICKS = 30
PINNED_TICKS = 45
WALL = UNREACHED - 1


@kernel
def human_gap2(floor: Floor, motion: Motion, cell: int) -> float:
    """Return the squared distance from the human to the centre of `cell`."""
    dx = floor.centers[cell, 0] - motion.trial[0].x
    dy = floor.centers[cell, 1] - motion.trial[0].y
    return dx * dx + dy * dy


@kernel
def human_allows(floor: Floor, motion: Motion, start: int, end: int) -> bool:
    """Say whether a robot may go from cell `start` to its neighbour `end` past the human's body.

    A robot that the human came close to may only go to a cell farther from the human.
    """
    gap2 = human_gap2(floor, motion, end)
    if gap2 >= 1.5:
        return True
    if gap2 < ZONE2 and not gap2 > human_gap2(floor, motion, start):
        return False
    ax = floor.centers[start, 0]
    ay = floor.centers[start, 1]
    ux = floor.centers[end, 0] - ax
    uy = floor.centers[end, 1] - ay
    wx = motion.trial[0].x - ax
    wy = motion.trial[0].y - ay
    along = (wx * ux + wy * uy) / (CELL_M * CELL_M)
    if along <= 0.0:
        return True
    if along >= 1.0:
        return gap2 >= STOP2
    qx = wx - along * ux
    qy = wy - along * uy
    return qx * qx + qy * qy >= STOP2


@kernel
def meets_human(floor: Floor, motion: Motion, robot: int, ahead: int) -> bool:
    """Say whether the human stands in one of the next `ahead` cells of the robot's plan."""
    r = motion.robots[robot]
    last = min(r.plan_at + ahead, r.plan_length - 1)
    for n in range(r.plan_at + 1, last + 1):
        if human_gap2(floor, motion, motion.plans[robot, n]) < ZONE2:
            return True
    return False


@kernel
def held_cells(motion: Motion, robot: int) -> int:
    """Write the cells that the robot must pass anyway to the queue's start; return how many."""
    r = motion.robots[robot]
    if r.mode == FORWARD:
        motion.queue[0] = r.tail
        motion.queue[1] = r.head
        if r.next >= 0:
            motion.queue[2] = r.next
            return 3
        return 2
    if r.mode == BACKWARD:
        motion.queue[0] = r.head
        motion.queue[1] = r.tail
        return 2
    motion.queue[0] = r.head
    return 1


@kernel
def heading_direction(motion: Motion, robot: int, held: int, stride: int) -> int:
    """Return the direction 0..3 in which the robot reaches the last of its held cells."""
    if held > 1:
        for d in range(4):
            if motion.queue[held - 2] + neighbour_offset(d, stride) == motion.queue[held - 1]:
                return d
    return int(((motion.robots[robot].heading + 8192) & 65535) >> 14)


@kernel
def adopt_plan(floor: Floor, motion: Motion, robot: int, detour: bool) -> None:
    """Replace the robot's plan by its held cells and the descent of the right field from there."""
    r = motion.robots[robot]
    stride = floor.hall[0].stride
    held = held_cells(motion, robot)
    heading = heading_direction(motion, robot, held, stride)
    start = motion.queue[held - 1]
    path = motion.queue[held - 1 : motion.plans.shape[1] - 1]
    if detour:
        length = held - 1 + descend(motion.field, stride, start, heading, path)
    else:
        length = held - 1 + descend(floor.fields[r.goal], stride, start, heading, path)
    if differs(motion, robot, length, held):
        r.plan_version += 1
    for n in range(length):
        motion.plans[robot, n] = motion.queue[n]
    r.plan_length = length
    r.plan_at = held - 1
    r.plan_tick = motion.trial[0].tick
    r.detour = detour


@kernel
def differs(motion: Motion, robot: int, length: int, held: int) -> bool:
    """Say whether the new plan in the queue is more than the old one without its passed cells."""
    r = motion.robots[robot]
    shift = r.plan_length - length
    if shift < 0 or r.plan_at - shift != held - 1:
        return True
    for n in range(length):
        if motion.plans[robot, n + shift] != motion.queue[n]:
            return True
    return False


@kernel
def find_way_round(floor: Floor, motion: Motion, robot: int) -> bool:
    """Fill the scratch field with ways to the goal round the human and robots that it pins."""
    r = motion.robots[robot]
    stride = floor.hall[0].stride
    held = held_cells(motion, robot)
    start = motion.queue[held - 1]
    field = motion.field
    for n in range(field.size):
        field[n] = UNREACHED
    for k in range(motion.robots.size):
        other = motion.robots[k]
        if k != robot and other.stuck >= PINNED_TICKS:
            field[other.tail] = WALL
            field[other.head] = WALL
            if other.next >= 0:
                field[other.next] = WALL
    column = int((motion.trial[0].x - floor.centers[0, 0]) / CELL_M + 0.5)
    row = int((motion.trial[0].y - floor.centers[0, 1]) / CELL_M + 0.5)
    for j in range(row - 1, row + 2):
        for i in range(column - 1, column + 2):
            cell = j * stride + i
            if human_gap2(floor, motion, cell) < ZONE2:
                field[cell] = WALL
    field[start] = UNREACHED
    fill_marked(floor.kinds, stride, floor.goal_cells[r.goal], field, motion.queue, start)
    for d in range(4):
        cell = start + neighbour_offset(d, stride)
        if field[cell] < field[start] and human_allows(floor, motion, start, cell):
            return True
    return False


@kernel
def shortest_way_meets_human(floor: Floor, motion: Motion, robot: int, ahead: int) -> bool:
    """Say whether the human stands in the next `ahead` cells of the shortest path."""
    stride = floor.hall[0].stride
    held = held_cells(motion, robot)
    heading = heading_direction(motion, robot, held, stride)
    start = motion.queue[held - 1]
    path = motion.queue[: ahead + 1]
    count = descend(floor.fields[motion.robots[robot].goal], stride, start, heading, path)
    for n in range(1, count):
        if human_gap2(floor, motion, path[n]) < ZONE2:
            return True
    return False


@kernel
def replan(floor: Floor, motion: Motion, robot: int) -> None:
    """Make the robot's plan anew: the shortest path, or a way round the human standing in it.

    A robot on a detour goes back to the shortest path only when no part of that is closed any more:
    else it would turn round as soon as the human is far enough, and again when it is near.
    """
    r = motion.robots[robot]
    if r.goal < 0:
        if r.plan_length > 0:
            r.plan_version += 1
        r.plan_length = 0
        r.plan_at = 0
        r.detour = 0
        r.held_up = 0
        return
    ahead = LOOK_AHEAD_CELLS
    if r.detour == 1:
        ahead = motion.plans.shape[1] - 4
    detour = False
    r.held_up = 0
    if shortest_way_meets_human(floor, motion, robot, ahead):
        detour = find_way_round(floor, motion, robot)
        r.held_up = not detour
    adopt_plan(floor, motion, robot, detour)


@kernel
def refresh_plan(floor: Floor, motion: Motion, robot: int) -> None:
    """Before the robot asks for its next cell: see whether its plan still holds."""
    r = motion.robots[robot]
    age = motion.trial[0].tick - r.plan_tick
    last = r.tail if r.mode == STANDING else r.head
    if r.plan_length == 0 or motion.plans[robot, r.plan_at] != last:
        replan(floor, motion, robot)
    elif meets_human(floor, motion, robot, LOOK_AHEAD_CELLS):
        if age >= REPLAN_TICKS:
            replan(floor, motion, robot)
    elif (r.detour == 1 or r.held_up == 1) and age >= RETRY_TICKS:
        replan(floor, motion, robot)
    elif r.plan_at == r.plan_length - 1:
        replan(floor, motion, robot)


@kernel
def follow_plan(floor: Floor, motion: Motion, robot: int, cell: int) -> None:
    """Record that the robot has claimed `cell`; make a new plan from there if that was not next."""
    r = motion.robots[robot]
    if r.plan_at + 1 < r.plan_length and motion.plans[robot, r.plan_at + 1] == cell:
        r.plan_at += 1
    else:
        replan(floor, motion, robot)
