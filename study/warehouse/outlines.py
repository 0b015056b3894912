"""A world in few whole numbers, for whoever sends it: places on a grid, paths as their corners."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from study.warehouse.kernels import kernel
from study.warehouse.planning import Records
from study.warehouse.routes import PAD
from study.warehouse.state import FORWARD

HUMAN_NUMBERS = 5
ROBOT_NUMBERS = 4


@kernel
def outline_world(
    trial: Records, robots: Records, per_m: float, numbers: npt.NDArray[np.int64]
) -> None:
    """Fill `numbers`, int64[5 + 4 N]: contact, tick, the human's x, y and yaw; then each robot.

    x and y are in 1/`per_m` m. A robot has x, y, heading (256ths of a turn) and its state + 8 times
    (carried colour + 1).
    """
    human = trial[0]
    numbers[0] = human.contact
    numbers[1] = human.tick
    numbers[2] = int(np.rint(human.x * per_m))
    numbers[3] = int(np.rint(human.y * per_m))
    numbers[4] = human.yaw
    for k in range(robots.size):
        r = robots[k]
        at = HUMAN_NUMBERS + ROBOT_NUMBERS * k
        numbers[at] = int(np.rint(r.x * per_m))
        numbers[at + 1] = int(np.rint(r.y * per_m))
        numbers[at + 2] = r.heading >> 8
        numbers[at + 3] = r.state + 8 * (r.carrying + 1)


@kernel
def outline_path(
    robots: Records,
    plans: npt.NDArray[np.int32],
    robot: int,
    stride: int,
    corners: npt.NDArray[np.int16],
) -> int:
    """Fill `corners`, int16[n, 2], with the cells where a planned path starts, turns and ends.

    It starts where the robot is. Returns their number, 0 without a path.
    """
    r = robots[robot]
    plan = plans[robot]
    here = r.head if r.mode == FORWARD and r.s >= 0.3 else r.tail
    start = r.plan_at
    while start > 0 and plan[start] != here:
        start -= 1
    count = 0
    last = r.plan_length - 1
    for n in range(start, last + 1):
        if start < n < last and plan[n] - plan[n - 1] == plan[n + 1] - plan[n]:
            continue
        corners[count, 0] = plan[n] % stride - PAD
        corners[count, 1] = plan[n] // stride - PAD
        count += 1
    return count
