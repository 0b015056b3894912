"""One tick of a world, 1/30 s: the human, the robots' lives, their right of way, their motion."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from study.warehouse.driving import drive
from study.warehouse.halls import CELL_M
from study.warehouse.kernels import kernel
from study.warehouse.kinematics import step_human, wanted_step
from study.warehouse.life import (
    TRIAL_COMPLETED,
    TRIAL_TIMED_OUT,
    change_state,
    something_ends,
    start_task,
    tell,
    watch_progress,
)
from study.warehouse.planning import Records, replan
from study.warehouse.right_of_way import settle
from study.warehouse.state import (
    COMPLETED,
    RUNNING,
    STANDING,
    TIMED_OUT,
    Floor,
    Motion,
    Record,
    Routes,
)

ROBOTS_APART2 = 0.4 * 0.4
REST_M = 0.3
HUMAN_APART2 = 0.5 * 0.5


@kernel
def move_human(floor: Floor, motion: Motion, keys: int, yaw: int) -> None:
    """Move the human by one input frame."""
    trial = motion.trial[0]
    trial.yaw = yaw
    column = int((trial.x - motion.cells[0].x) / CELL_M + 0.5)
    row = int((trial.y - motion.cells[0].y) / CELL_M + 0.5)
    near = floor.near_solids[row * floor.hall[0].stride + column]
    wanted = wanted_step(keys, yaw, floor.hall[0].human_step_m, floor.cosines)
    for k in range(motion.robots.size):
        motion.others[k, 0] = motion.robots[k].x
        motion.others[k, 1] = motion.robots[k].y
    x, y, contact = step_human((trial.x, trial.y), wanted, floor.solids, near, motion.others)
    trial.path_m += np.sqrt((x - trial.x) * (x - trial.x) + (y - trial.y) * (y - trial.y))
    trial.x = x
    trial.y = y
    if contact:
        trial.contact = 1


@kernel
def count_overlaps(trial: Record, robots: Records, others: npt.NDArray[np.float64]) -> None:
    """Count pairs of bodies that overlap now; there should never be any."""
    for k in range(robots.size):
        x = robots[k].x
        y = robots[k].y
        others[k, 0] = x
        others[k, 1] = y
        if (x - trial.x) * (x - trial.x) + (y - trial.y) * (y - trial.y) < HUMAN_APART2:
            trial.overlaps += 1
        for m in range(k):
            dx = x - others[m, 0]
            dy = y - others[m, 1]
            if dx * dx + dy * dy < ROBOTS_APART2:
                trial.overlaps += 1


@kernel
def move_robots(floor: Floor, motion: Motion) -> None:
    """Settle the right of way, drive every robot and keep plans and stall clocks."""
    trial = motion.trial[0]
    stride = floor.hall[0].stride
    robots = motion.robots
    cells = motion.cells
    routes = Routes(floor.fields, floor.goals, motion.plans, motion.field, motion.queue)
    settle(trial, robots, cells, routes, motion.stack, motion.order, stride)
    for k in range(robots.size):
        r = robots[k]
        if r.mode != STANDING:
            drive(trial, cells, motion.bays, r, floor.hall[0].robot_step_m)
        if r.replan == 1:
            r.replan = 0
            replan(trial, robots, cells, routes, r, stride)
        if r.goal >= 0:
            cell = r.tail if r.s < 0.3 else r.head
            left = floor.fields[r.goal, cell]
            watch_progress(trial, cells, floor.goals, r, left, stride)


@kernel
def step_world(floor: Floor, motion: Motion, frames: npt.NDArray[np.int32], count: int) -> int:
    """Advance a running trial by one tick with `count` frames (keys, yaw) of the human.

    Returns how many events there were. A trial that has ended stays as it is.
    """
    trial = motion.trial[0]
    hall = floor.hall[0]
    if trial.status != RUNNING:
        return 0
    trial.events = 0
    if trial.tick == 0:
        for k in range(motion.robots.size):
            start_task(floor, motion, k)
    trial.tick += 1
    trial.contact = 0
    path_before_m = trial.path_m
    for n in range(count):
        move_human(floor, motion, frames[n, 0], frames[n, 1])
    if trial.path_m == path_before_m:
        trial.still_ticks += 1
    dx = trial.x - trial.rest_x
    dy = trial.y - trial.rest_y
    trial.rest_ticks += 1
    if dx * dx + dy * dy > REST_M * REST_M:
        trial.rest_x = trial.x
        trial.rest_y = trial.y
        trial.rest_ticks = 0
    for k in range(motion.robots.size):
        if something_ends(trial, hall, motion.robots[k], floor.fields, floor.stations):
            change_state(floor, motion, k)
    move_robots(floor, motion)
    count_overlaps(trial, motion.robots, motion.others)
    if trial.home == motion.robots.size:
        trial.status = COMPLETED
        tell(motion, TRIAL_COMPLETED, -1, 0, 0)
    elif trial.tick >= hall.cap_ticks:
        trial.status = TIMED_OUT
        tell(motion, TRIAL_TIMED_OUT, -1, 0, 0)
    return int(trial.events)
