"""The human's motion: one rule, the same to the bit here and in the browser.

One input frame is 1/30 s of motion: which of the keys W A S D are held, and the view's yaw.

1. f = W - S, r = D - A. Both 0: nothing moves.
2. cosine and sine of the yaw come from one table of 4096 entries, index `yaw >> 4`.
3. dx = f cos + r sin, dy = f sin - r cos; both keys: times 0.7071...; times speed / 30.
4. The wanted place is (x + dx, y + dy).
5. Up to three passes: every solid rectangle in order, then every robot in order, pushes the wanted
   place out along the shortest way to a distance of the radii plus a skin of 1/8192 m.
6. The place is taken if it overlaps nothing; else the step along x alone, else along y alone, else
   the human stands.

So the human slides along walls and around robots, never overlaps a body and pushes none. Only
+ - * / and sqrt are used, which IEEE 754 fixes to the last bit; no library function enters the
state. Our choice: the whole rule (the authors' simulator leaves it to its physics engine).
"""

from __future__ import annotations

import functools
import math

import numpy as np
import numpy.typing as npt

from study.warehouse.kernels import kernel

KEY_W = 1
KEY_A = 2
KEY_S = 4
KEY_D = 8
YAW_STEPS = 65536
TABLE_STEPS = 4096
FRAME_HZ = 30

SKIN_M = 1 / 8192
BODY_M = 0.3 + SKIN_M
BODY2 = BODY_M * BODY_M
PAIR_M = 0.5 + SKIN_M
PAIR2 = PAIR_M * PAIR_M
BODY_MIN2 = 0.3 * 0.3
PAIR_MIN2 = 0.5 * 0.5
DIAGONAL = 0.7071067811865476
PASSES = 3

Floats = npt.NDArray[np.float64]


@functools.cache
def trig_table() -> Floats:
    """Return cosines, float64[4096], rounded to 24 binary places; sine of k is entry k - 1024."""
    scale = float(1 << 24)
    table = np.array(
        [
            math.floor(math.cos(2.0 * math.pi * k / TABLE_STEPS) * scale + 0.5) / scale
            for k in range(TABLE_STEPS)
        ]
    )
    table.setflags(write=False)
    return table


@kernel
def rectangle_gap(px: float, py: float, solids: Floats, n: int) -> tuple[float, float, float]:
    """Return the nearest point of solid `n` to (px, py) and the squared distance to it."""
    qx = px
    if px < solids[n, 0]:
        qx = solids[n, 0]
    elif px > solids[n, 2]:
        qx = solids[n, 2]
    qy = py
    if py < solids[n, 1]:
        qy = solids[n, 1]
    elif py > solids[n, 3]:
        qy = solids[n, 3]
    ux = px - qx
    uy = py - qy
    return qx, qy, ux * ux + uy * uy


@kernel
def is_free(
    px: float, py: float, solids: Floats, near: npt.NDArray[np.int16], others: Floats
) -> bool:
    """Say whether the human's body at (px, py) overlaps no solid in `near` and no robot."""
    for m in range(near.size):
        if near[m] < 0:
            break
        if rectangle_gap(px, py, solids, near[m])[2] < BODY_MIN2:
            return False
    for k in range(others.shape[0]):
        ux = px - others[k, 0]
        uy = py - others[k, 1]
        if ux * ux + uy * uy < PAIR_MIN2:
            return False
    return True


@kernel
def push_out(
    px: float, py: float, solids: Floats, near: npt.NDArray[np.int16], others: Floats
) -> tuple[float, float, bool, bool]:
    """Push the place (px, py) out of all bodies: new place, whether a robot touched, if stuck."""
    contact = False
    inside = False
    for _ in range(PASSES):
        moved = False
        for m in range(near.size):
            if near[m] < 0:
                break
            qx, qy, d2 = rectangle_gap(px, py, solids, near[m])
            if d2 < BODY2:
                if d2 == 0.0:
                    inside = True
                else:
                    g = BODY_M / math.sqrt(d2)
                    px = qx + (px - qx) * g
                    py = qy + (py - qy) * g
                    moved = True
        for k in range(others.shape[0]):
            ux = px - others[k, 0]
            uy = py - others[k, 1]
            d2 = ux * ux + uy * uy
            if d2 < PAIR2:
                contact = True
                if d2 == 0.0:
                    inside = True
                else:
                    g = PAIR_M / math.sqrt(d2)
                    px = others[k, 0] + ux * g
                    py = others[k, 1] + uy * g
                    moved = True
        if not moved:
            break
    return px, py, contact, inside


@kernel
def wanted_step(keys: int, yaw: int, step_m: float, cosines: Floats) -> tuple[float, float]:
    """Return the free displacement (dx, dy) of one frame in metres."""
    f = float((keys & 1) - ((keys >> 2) & 1))
    r = float(((keys >> 3) & 1) - ((keys >> 1) & 1))
    k = yaw >> 4
    c = cosines[k]
    s = cosines[(k - 1024) & 4095]
    dx = f * c + r * s
    dy = f * s - r * c
    if f != 0.0 and r != 0.0:
        dx = dx * DIAGONAL
        dy = dy * DIAGONAL
    return dx * step_m, dy * step_m


@kernel
def step_human(
    place: tuple[float, float],
    wanted: tuple[float, float],
    solids: Floats,
    near: npt.NDArray[np.int16],
    others: Floats,
) -> tuple[float, float, bool]:
    """Move the human by one frame: new x, y in metres, and whether a robot was in the way.

    `near`: indices of the solids that may matter here, ascending, filled up with -1; solids further
    away cannot change the result. `others`: robots' places, float64[n, 2].
    """
    x, y = place
    dx, dy = wanted
    if dx == 0.0 and dy == 0.0:
        return x, y, False
    px, py, contact, inside = push_out(x + dx, y + dy, solids, near, others)
    if not inside and is_free(px, py, solids, near, others):
        return px, py, contact
    if is_free(x + dx, y, solids, near, others):
        return x + dx, y, contact
    if is_free(x, y + dy, solids, near, others):
        return x, y + dy, contact
    return x, y, contact
