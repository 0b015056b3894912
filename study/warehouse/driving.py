"""Robots in continuous motion between the cells that they hold.

A robot drives from the centre of its `tail` cell to that of its `head`, `s` metres along, and on to
`next` without stopping if it was given that in time; a corner is rounded by a parabola that starts
and ends `turn_m` before and after the centre. So a body is always within 0.08 m (per axis) of the
lines between the cells it holds, and two bodies that hold different cells keep more than 0.4 m.

A robot halts rather than come nearer to the human than 0.506 m. After 0.7 s it drives back, or
straight to the corner's centre where both ends of the corner are closed.
"""

from __future__ import annotations

import math

from study.warehouse.halls import CELL_M
from study.warehouse.kernels import kernel
from study.warehouse.planning import STOP2, replan
from study.warehouse.routes import BAY
from study.warehouse.state import BACKWARD, CENTRING, FORWARD, STANDING, Floor, Motion

TURN_STEP = 1092
"""Turning on the spot, 180 degrees per second, in 65536ths of a turn per tick."""
PATIENCE_TICKS = 21


@kernel
def direction_of(offset: int) -> int:
    """Return 0 right, 1 up, 2 left, 3 down of an index difference between neighbours."""
    if offset == 1:
        return 0
    if offset == -1:
        return 2
    return 1 if offset > 0 else 3


@kernel
def place_at(floor: Floor, motion: Motion, robot: int, s: float) -> tuple[float, float]:
    """Return the place `s` metres along the robot's way from its tail over its head to its next."""
    r = motion.robots[robot]
    ax = floor.centers[r.tail, 0]
    ay = floor.centers[r.tail, 1]
    bx = floor.centers[r.head, 0]
    by = floor.centers[r.head, 1]
    turn = r.turn_m
    if turn == 0.0 or s <= CELL_M - turn:
        share = s / CELL_M
        return ax + (bx - ax) * share, ay + (by - ay) * share
    t = (s - (CELL_M - turn)) / (2.0 * turn)
    back = (1.0 - t) * (1.0 - t) * turn / CELL_M
    on = t * t * turn / CELL_M
    x = bx + back * (ax - bx) + on * (floor.centers[r.next, 0] - bx)
    y = by + back * (ay - by) + on * (floor.centers[r.next, 1] - by)
    return x, y


@kernel
def heading_at(motion: Motion, robot: int, s: float) -> int:
    """Return the heading (65536ths of a turn) `s` metres along the robot's way."""
    r = motion.robots[robot]
    first = direction_of(r.head - r.tail) << 14
    if r.turn_m == 0.0 or s <= CELL_M - r.turn_m:
        return first
    turn = ((direction_of(r.next - r.head) << 14) - first) & 65535
    if turn == 49152:
        turn = -16384
    t = (s - (CELL_M - r.turn_m)) / (2.0 * r.turn_m)
    return (first + int(turn * min(1.0, t))) & 65535


@kernel
def go_to(motion: Motion, robot: int, x: float, y: float) -> bool:
    """Put the robot at (x, y) unless that comes too near to the human; say whether it went."""
    r = motion.robots[robot]
    hx = motion.trial[0].x
    hy = motion.trial[0].y
    gap2 = (x - hx) * (x - hx) + (y - hy) * (y - hy)
    if gap2 < STOP2 and gap2 < (r.x - hx) * (r.x - hx) + (r.y - hy) * (r.y - hy):
        return False
    step_m = math.sqrt((x - r.x) * (x - r.x) + (y - r.y) * (y - r.y))
    r.path_m += step_m
    r.x = x
    r.y = y
    return True


@kernel
def release(floor: Floor, motion: Motion, robot: int, cell: int) -> None:
    """Give a cell back; a bay's reservation ends when the robot has left it."""
    motion.holds[cell] = -1
    r = motion.robots[robot]
    if floor.kinds[cell] == BAY and r.bay >= 0 and r.carrying < 0:
        motion.bays[r.bay] = -1
        r.bay = -1


@kernel
def stand_in(floor: Floor, motion: Motion, robot: int, cell: int) -> None:
    """End the robot's way in the centre of `cell` and give back the other cells it holds."""
    r = motion.robots[robot]
    for held in (r.tail, r.head, r.next):
        if held >= 0 and held != cell and motion.holds[held] == robot:
            release(floor, motion, robot, held)
    r.tail = cell
    r.head = cell
    r.next = -1
    r.s = 0.0
    r.turn_m = 0.0
    r.stuck = 0
    r.mode = STANDING
    r.x = floor.centers[cell, 0]
    r.y = floor.centers[cell, 1]


@kernel
def drive_forward(floor: Floor, motion: Motion, robot: int) -> bool:
    """Drive one tick towards the head; say whether the human was not in the way."""
    r = motion.robots[robot]
    if r.s == 0.0:
        wanted = direction_of(r.head - r.tail) << 14
        off = (wanted - int(r.heading)) & 65535
        if off != 0:
            if off > 32768:
                off -= 65536
            off = max(-TURN_STEP, min(TURN_STEP, off))
            r.heading = (int(r.heading) + off) & 65535
            return True
    s = r.s + floor.hall[0].robot_step_m
    if r.next < 0 and s >= CELL_M:
        if not go_to(motion, robot, floor.centers[r.head, 0], floor.centers[r.head, 1]):
            return False
        stand_in(floor, motion, robot, r.head)
        return True
    if r.next >= 0 and s >= CELL_M + r.turn_m:
        return pass_on(floor, motion, robot, s - CELL_M)
    x, y = place_at(floor, motion, robot, s)
    if not go_to(motion, robot, x, y):
        return False
    r.s = s
    r.heading = heading_at(motion, robot, s)
    return True


@kernel
def pass_on(floor: Floor, motion: Motion, robot: int, s: float) -> bool:
    """Leave the tail behind: the head becomes the tail, the next the head."""
    r = motion.robots[robot]
    ax = floor.centers[r.head, 0]
    ay = floor.centers[r.head, 1]
    share = s / CELL_M
    x = ax + (floor.centers[r.next, 0] - ax) * share
    y = ay + (floor.centers[r.next, 1] - ay) * share
    if not go_to(motion, robot, x, y):
        return False
    release(floor, motion, robot, r.tail)
    r.tail = r.head
    r.head = r.next
    r.next = -1
    r.turn_m = 0.0
    r.s = s
    r.heading = direction_of(r.head - r.tail) << 14
    return True


@kernel
def drive_backward(floor: Floor, motion: Motion, robot: int) -> bool:
    """Drive one tick back to the tail; say whether the human was not in the way."""
    r = motion.robots[robot]
    s = max(0.0, r.s - floor.hall[0].robot_step_m)
    x, y = place_at(floor, motion, robot, s)
    if not go_to(motion, robot, x, y):
        return False
    r.s = s
    r.heading = heading_at(motion, robot, s)
    if s == 0.0:
        stand_in(floor, motion, robot, r.tail)
        replan(floor, motion, robot)
    return True


@kernel
def drive_to_centre(floor: Floor, motion: Motion, robot: int) -> bool:
    """Drive one tick straight to the head's centre; say whether the human was not in the way."""
    r = motion.robots[robot]
    ux = floor.centers[r.head, 0] - r.x
    uy = floor.centers[r.head, 1] - r.y
    left = math.sqrt(ux * ux + uy * uy)
    step = floor.hall[0].robot_step_m
    if left <= step:
        if not go_to(motion, robot, floor.centers[r.head, 0], floor.centers[r.head, 1]):
            return False
        stand_in(floor, motion, robot, r.head)
        replan(floor, motion, robot)
        return True
    return go_to(motion, robot, r.x + ux / left * step, r.y + uy / left * step)


@kernel
def drive(floor: Floor, motion: Motion, robot: int) -> None:
    """Move the robot by one tick; change its mind when the human stays in the way."""
    r = motion.robots[robot]
    if r.mode == STANDING:
        return
    if r.mode == FORWARD:
        went = drive_forward(floor, motion, robot)
    elif r.mode == BACKWARD:
        went = drive_backward(floor, motion, robot)
    else:
        went = drive_to_centre(floor, motion, robot)
    if went:
        r.stuck = 0
        return
    r.stuck += 1
    if r.stuck % PATIENCE_TICKS != 0 or r.mode == CENTRING:
        return
    on_corner = r.turn_m > 0.0 and r.s > CELL_M - r.turn_m
    if r.mode == BACKWARD:
        r.mode = FORWARD
    elif on_corner and not backs_away(floor, motion, robot):
        r.mode = CENTRING
    else:
        r.mode = BACKWARD
    replan(floor, motion, robot)


@kernel
def backs_away(floor: Floor, motion: Motion, robot: int) -> bool:
    """Say whether driving back leads the robot away from the human."""
    r = motion.robots[robot]
    hx = motion.trial[0].x
    hy = motion.trial[0].y
    x, y = place_at(floor, motion, robot, max(0.0, r.s - floor.hall[0].robot_step_m))
    gap2 = (x - hx) * (x - hx) + (y - hy) * (y - hy)
    return bool(gap2 >= (r.x - hx) * (r.x - hx) + (r.y - hy) * (r.y - hy))
