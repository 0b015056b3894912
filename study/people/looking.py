"""What a person can see of the hall and of the display, and what is noticed of it [our choice].

Seeing is geometry: the view's angle, range, and shelves in the line of sight. AR elements are seen
through shelves at any range. Noticing is chance: it falls with the number of things in view.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from study.warehouse.halls import CELL_M
from study.warehouse.kernels import kernel
from study.warehouse.planning import Records
from study.warehouse.routes import PAD, SOLID
from study.warehouse.state import RETURNING, TO_SHELF, TO_STATION, Record
from study.warehouse.tasks import next_draw

Draws = npt.NDArray[np.uint64]
Floats = npt.NDArray[np.float64]

VIEW = np.dtype(
    [
        ("x", "f8"), ("y", "f8"), ("look_x", "f8"), ("look_y", "f8"), ("cosine", "f8"),
        ("sight_m", "f8"), ("through", "i4"),
    ],
    align=True,
)  # fmt: skip
"""Where a person stands and looks. `look_x`, `look_y`: unit vector; `cosine` of half the view's
angle, -1 all around; `through`: 1 for a view from above, where no shelf hides anything."""

SIGHT_STEP_M = 0.3


@kernel
def chance(draws: Draws) -> float:
    """Return the next random number in [0, 1)."""
    return (next_draw(draws) >> 10) / 9007199254740992.0


@kernel
def in_view(view: Record, x: float, y: float) -> bool:
    """Say whether a place lies within the view's angle."""
    dx = x - view.x
    dy = y - view.y
    along = dx * view.look_x + dy * view.look_y
    return bool(along >= view.cosine * np.sqrt(dx * dx + dy * dy))


@kernel
def in_sight(view: Record, cells: Records, x: float, y: float, stride: int) -> bool:
    """Say whether a body at a place is seen directly: in view, in range, no shelf between.

    The posts between bays and homes are low: of what is solid only shelves hide anything.
    """
    if view.through == 1:
        return True
    dx = x - view.x
    dy = y - view.y
    far2 = dx * dx + dy * dy
    if far2 > view.sight_m * view.sight_m or not in_view(view, x, y):
        return False
    rows = cells.size // stride
    steps = int(np.sqrt(far2) / SIGHT_STEP_M)
    left = (view.x - cells[0].x) / CELL_M + 0.5
    low = (view.y - cells[0].y) / CELL_M + 0.5
    for n in range(1, steps):
        column = int(left + dx / CELL_M * n / steps)
        row = int(low + dy / CELL_M * n / steps)
        inside = PAD <= column < stride - PAD and PAD <= row < rows - PAD
        if inside and cells[row * stride + column].kind == SOLID:
            return False
    return True


@kernel
def is_driving(state: int) -> bool:
    """Say whether a robot in this state has a path, so that ribbon and ghost draw something."""
    return state in (TO_SHELF, TO_STATION, RETURNING)


@kernel
def elements_in_view(
    view: Record, robots: Records, k: int, shown: int, goal_x: float, goal_y: float
) -> int:
    """Return the robot's AR elements that draw something in the view (mask).

    Avatars are where the robot is; a ribbon is in view if either of its ends is.
    """
    mask = 0
    here = in_view(view, robots[k].x, robots[k].y)
    if here:
        mask |= shown & 1
    if is_driving(robots[k].state):
        if here:
            mask |= shown & 2
        if here or in_view(view, goal_x, goal_y):
            mask |= shown & 12
    return mask
