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

import numpy as np
import numpy.typing as npt

from study.warehouse.halls import CELL_M
from study.warehouse.kernels import kernel
from study.warehouse.planning import STOP2, Records
from study.warehouse.routes import BAY
from study.warehouse.state import BACKWARD, CENTRING, FORWARD, STANDING, Record

Bays = npt.NDArray[np.int16]

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
def place_at(cells: Records, r: Record, s: float) -> tuple[float, float]:
    """Return the place `s` metres along the robot's way from its tail over its head to its next."""
    ax = cells[r.tail].x
    ay = cells[r.tail].y
    bx = cells[r.head].x
    by = cells[r.head].y
    turn = r.turn_m
    if turn == 0.0 or s <= CELL_M - turn:
        share = s / CELL_M
        return ax + (bx - ax) * share, ay + (by - ay) * share
    t = (s - (CELL_M - turn)) / (2.0 * turn)
    back = (1.0 - t) * (1.0 - t) * turn / CELL_M
    on = t * t * turn / CELL_M
    x = bx + back * (ax - bx) + on * (cells[r.next].x - bx)
    y = by + back * (ay - by) + on * (cells[r.next].y - by)
    return x, y


@kernel
def heading_at(r: Record, s: float) -> int:
    """Return the heading (65536ths of a turn) `s` metres along the robot's way."""
    first = direction_of(r.head - r.tail) << 14
    if r.turn_m == 0.0 or s <= CELL_M - r.turn_m:
        return first
    turn = ((direction_of(r.next - r.head) << 14) - first) & 65535
    if turn == 49152:
        turn = -16384
    t = (s - (CELL_M - r.turn_m)) / (2.0 * r.turn_m)
    return (first + int(turn * min(1.0, t))) & 65535


@kernel
def go_to(trial: Record, r: Record, x: float, y: float) -> bool:
    """Put the robot at (x, y) unless that comes too near to the human; say whether it went."""
    hx = trial.x
    hy = trial.y
    gap2 = (x - hx) * (x - hx) + (y - hy) * (y - hy)
    if gap2 < STOP2 and gap2 < (r.x - hx) * (r.x - hx) + (r.y - hy) * (r.y - hy):
        return False
    step_m = math.sqrt((x - r.x) * (x - r.x) + (y - r.y) * (y - r.y))
    r.path_m += step_m
    r.x = x
    r.y = y
    return True


@kernel
def release(cells: Records, bays: Bays, r: Record, cell: int) -> None:
    """Give a cell back; a bay's reservation ends when the robot has left it."""
    cells[cell].holder = -1
    if cells[cell].kind == BAY and r.bay >= 0 and r.carrying < 0:
        bays[r.bay] = -1
        r.bay = -1


@kernel
def stand_in(cells: Records, bays: Bays, r: Record, cell: int) -> None:
    """End the robot's way in the centre of `cell` and give back the other cells it holds."""
    for held in (r.tail, r.head, r.next):
        if held >= 0 and held != cell and cells[held].holder == r.index:
            release(cells, bays, r, held)
    r.tail = cell
    r.head = cell
    r.next = -1
    r.s = 0.0
    r.turn_m = 0.0
    r.stuck = 0
    r.mode = STANDING
    r.x = cells[cell].x
    r.y = cells[cell].y


@kernel
def drive_forward(trial: Record, cells: Records, bays: Bays, r: Record, step_m: float) -> bool:
    """Drive one tick towards the head; say whether the human was not in the way."""
    if r.s == 0.0:
        wanted = direction_of(r.head - r.tail) << 14
        off = (wanted - int(r.heading)) & 65535
        if off != 0:
            if off > 32768:
                off -= 65536
            off = max(-TURN_STEP, min(TURN_STEP, off))
            r.heading = (int(r.heading) + off) & 65535
            return True
    s = r.s + step_m
    if r.next < 0 and s >= CELL_M:
        if not go_to(trial, r, cells[r.head].x, cells[r.head].y):
            return False
        stand_in(cells, bays, r, r.head)
        return True
    if r.next >= 0 and s >= CELL_M + r.turn_m:
        return pass_on(trial, cells, bays, r, s - CELL_M)
    x, y = place_at(cells, r, s)
    if not go_to(trial, r, x, y):
        return False
    r.s = s
    r.heading = heading_at(r, s)
    return True


@kernel
def pass_on(trial: Record, cells: Records, bays: Bays, r: Record, s: float) -> bool:
    """Leave the tail behind: the head becomes the tail, the next the head."""
    ax = cells[r.head].x
    ay = cells[r.head].y
    share = s / CELL_M
    x = ax + (cells[r.next].x - ax) * share
    y = ay + (cells[r.next].y - ay) * share
    if not go_to(trial, r, x, y):
        return False
    release(cells, bays, r, r.tail)
    r.tail = r.head
    r.head = r.next
    r.next = -1
    r.turn_m = 0.0
    r.s = s
    r.heading = direction_of(r.head - r.tail) << 14
    return True


@kernel
def drive_backward(trial: Record, cells: Records, bays: Bays, r: Record, step_m: float) -> bool:
    """Drive one tick back to the tail; say whether the human was not in the way."""
    s = max(0.0, r.s - step_m)
    x, y = place_at(cells, r, s)
    if not go_to(trial, r, x, y):
        return False
    r.s = s
    r.heading = heading_at(r, s)
    if s == 0.0:
        stand_in(cells, bays, r, r.tail)
        r.replan = 1
    return True


@kernel
def drive_to_centre(trial: Record, cells: Records, bays: Bays, r: Record, step_m: float) -> bool:
    """Drive one tick straight to the head's centre; say whether the human was not in the way."""
    ux = cells[r.head].x - r.x
    uy = cells[r.head].y - r.y
    left = math.sqrt(ux * ux + uy * uy)
    if left <= step_m:
        if not go_to(trial, r, cells[r.head].x, cells[r.head].y):
            return False
        stand_in(cells, bays, r, r.head)
        r.replan = 1
        return True
    return go_to(trial, r, r.x + ux / left * step_m, r.y + uy / left * step_m)


@kernel
def drive(trial: Record, cells: Records, bays: Bays, r: Record, step_m: float) -> None:
    """Move the robot by one tick; change its mind when the human stays in the way."""
    if r.mode == STANDING:
        return
    if r.mode == FORWARD:
        went = drive_forward(trial, cells, bays, r, step_m)
    elif r.mode == BACKWARD:
        went = drive_backward(trial, cells, bays, r, step_m)
    else:
        went = drive_to_centre(trial, cells, bays, r, step_m)
    if went:
        r.stuck = 0
        return
    r.stuck += 1
    if r.stuck % PATIENCE_TICKS != 0 or r.mode == CENTRING:
        return
    on_corner = r.turn_m > 0.0 and r.s > CELL_M - r.turn_m
    if r.mode == BACKWARD:
        r.mode = FORWARD
    elif on_corner and not backs_away(trial, cells, r, step_m):
        r.mode = CENTRING
    else:
        r.mode = BACKWARD
    r.replan = 1


@kernel
def backs_away(trial: Record, cells: Records, r: Record, step_m: float) -> bool:
    """Say whether driving back leads the robot away from the human."""
    hx = trial.x
    hy = trial.y
    x, y = place_at(cells, r, max(0.0, r.s - step_m))
    gap2 = (x - hx) * (x - hx) + (y - hy) * (y - hy)
    return bool(gap2 >= (r.x - hx) * (r.x - hx) + (r.y - hy) * (r.y - hy))
