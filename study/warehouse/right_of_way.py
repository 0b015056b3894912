"""Who may enter which cell: priority inheritance with backtracking, asynchronous and iterative.

A robot holds the cell it leaves until it has arrived in the next, so two robots never hold the same
cell and disjoint cells keep bodies apart. A robot asks for its next cell when it stands, or half a
cell before the centre it is coming to. If a robot of lower priority stands in the wanted cell, that
one must make room first and inherits the right to push others (PIBT; Okumura et al. 2022, in its
form for robots that take their time). The method's promise needs a biconnected graph, so dead ends
are private: a bay may be entered by the robot that reserved it, a home by its owner.

Order of right: a robot leaving its bay or home, then whoever pursues its goal for longest; last come
robots whose way the human closes, so that others may push them aside.
"""

from __future__ import annotations

from study.warehouse.halls import CELL_M
from study.warehouse.kernels import kernel
from study.warehouse.planning import follow_plan, human_allows, refresh_plan
from study.warehouse.routes import SHARED, SOLID, neighbour_offset
from study.warehouse.state import (
    FORWARD,
    RETURNING,
    STANDING,
    TO_SHELF,
    TO_STATION,
    Floor,
    Motion,
)

WINDOW_M = 0.3
"""A robot asks for its next cell from this distance before a centre on..."""
LEAST_TURN_M = 0.1
"""... to this one; later it is too late to round the corner, and it stops there first."""
AGENT, TRIED, COUNT, FIRST = range(4)


@kernel
def is_moving(motion: Motion, robot: int) -> bool:
    """Say whether the robot has a goal to drive to."""
    state = motion.robots[robot].state
    return bool(state == TO_SHELF or state == TO_STATION or state == RETURNING)


@kernel
def may_ask(floor: Floor, motion: Motion, robot: int) -> bool:
    """Say whether the robot needs its next cell now."""
    r = motion.robots[robot]
    if not is_moving(motion, robot) or r.next >= 0 or floor.fields[r.goal, r.head] == 0:
        return False
    if r.mode == STANDING:
        return True
    left = CELL_M - r.s
    return bool(r.mode == FORWARD and r.stuck == 0 and LEAST_TURN_M <= left <= WINDOW_M)


@kernel
def may_enter(floor: Floor, motion: Motion, robot: int, start: int, cell: int) -> bool:
    """Say whether the robot may ever go from `start` to its neighbour `cell` as things stand."""
    kind = floor.kinds[cell]
    if kind == SOLID:
        return False
    r = motion.robots[robot]
    if kind != SHARED and floor.fields[r.goal, cell] != 0:
        return False
    return human_allows(floor, motion, start, cell)


@kernel
def list_candidates(floor: Floor, motion: Motion, robot: int, depth: int) -> None:
    """Write the cells that the robot would take, best first, to its frame of the stack.

    First the planned one, then others nearer to the goal; a robot that is pushed also takes those
    farther from it. A robot that is not pushed stays on its detour rather than leave it.
    """
    r = motion.robots[robot]
    frame = motion.stack[depth]
    start = r.head
    field = floor.fields[r.goal]
    count = 0
    planned = -1
    if r.plan_at + 1 < r.plan_length and motion.plans[robot, r.plan_at] == start:
        planned = motion.plans[robot, r.plan_at + 1]
        if planned != r.tail and may_enter(floor, motion, robot, start, planned):
            frame[FIRST] = planned
            count = 1
    for further in range(2 if depth > 0 else 1):
        if depth == 0 and r.detour == 1:
            break
        for d in range(4):
            cell = start + neighbour_offset(d, floor.hall[0].stride)
            if cell == planned or cell == r.tail or (field[cell] > field[start]) != (further == 1):
                continue
            if may_enter(floor, motion, robot, start, cell):
                frame[FIRST + count] = cell
                count += 1
    frame[AGENT] = robot
    frame[TRIED] = 0
    frame[COUNT] = count
    r.decided = motion.trial[0].tick


@kernel
def claim(floor: Floor, motion: Motion, robot: int, cell: int) -> None:
    """Give `cell` to the robot: it starts towards it, or will go on there without stopping."""
    r = motion.robots[robot]
    motion.holds[cell] = robot
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
    follow_plan(floor, motion, robot, cell)


@kernel
def ask(floor: Floor, motion: Motion, robot: int) -> None:
    """Let the robot claim a cell, pushing others of lower right out of its way where it must."""
    tick = motion.trial[0].tick
    depth = 0
    list_candidates(floor, motion, robot, 0)
    while depth >= 0:
        frame = motion.stack[depth]
        if frame[TRIED] >= frame[COUNT]:
            depth -= 1
            continue
        cell = frame[FIRST + frame[TRIED]]
        frame[TRIED] += 1
        holder = motion.holds[cell]
        if holder < 0:
            claim(floor, motion, frame[AGENT], cell)
            return
        other = motion.robots[holder]
        if other.mode != STANDING:
            if other.tail == cell and other.mode == FORWARD and other.stuck == 0:
                return
            continue
        if other.decided == tick or floor.kinds[cell] != SHARED or not is_moving(motion, holder):
            continue
        refresh_plan(floor, motion, holder)
        depth += 1
        list_candidates(floor, motion, holder, depth)


@kernel
def settle(floor: Floor, motion: Motion) -> None:
    """Let every robot that needs a cell ask for it, in the order of right."""
    count = 0
    order = motion.order
    for k in range(motion.robots.size):
        if not may_ask(floor, motion, k):
            continue
        refresh_plan(floor, motion, k)
        r = motion.robots[k]
        rank = 1 + r.held_up
        if floor.kinds[r.tail] != SHARED and r.mode == STANDING:
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
        if motion.robots[robot].decided != motion.trial[0].tick:
            ask(floor, motion, robot)
