"""A robot's life: to a shelf, picking, to a station, waiting, unloading; at the end back home.

The unload radius of 1.0 m and the life's order are the paper's; pick and unload times, the latch
(unloading goes on even if the human walks away) and the bays are our choice.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from study.warehouse.kernels import kernel
from study.warehouse.planning import ZONE2, Records, human_gap2
from study.warehouse.routes import SHARED, neighbour_offset
from study.warehouse.state import (
    HOME_STATE,
    PICKING,
    RETURNING,
    STANDING,
    TO_SHELF,
    TO_STATION,
    UNLOADING,
    WAITING,
    Floor,
    Motion,
    Record,
)
from study.warehouse.tasks import box_colour, reserve_bay

Floats = npt.NDArray[np.float64]

EVENT_KINDS = (
    "leg_started",
    "box_picked",
    "wait_started",
    "unload_started",
    "box_delivered",
    "returning_started",
    "home_reached",
    "trial_completed",
    "trial_timed_out",
)
(
    LEG_STARTED,
    BOX_PICKED,
    WAIT_STARTED,
    UNLOAD_STARTED,
    BOX_DELIVERED,
    RETURNING_STARTED,
    HOME_REACHED,
    TRIAL_COMPLETED,
    TRIAL_TIMED_OUT,
) = range(9)


@kernel
def tell(motion: Motion, kind: int, robot: int, a: int, b: int) -> None:
    """Note an event of this tick."""
    trial = motion.trial[0]
    if trial.events < motion.events.shape[0]:
        motion.events[trial.events, 0] = kind
        motion.events[trial.events, 1] = robot
        motion.events[trial.events, 2] = a
        motion.events[trial.events, 3] = b
        trial.events += 1


@kernel
def close_leg(motion: Motion, robot: int, station: int) -> None:
    """Write down the leg that ends now and start the next."""
    trial = motion.trial[0]
    r = motion.robots[robot]
    if trial.legs < motion.legs.size:
        leg = motion.legs[trial.legs]
        leg.robot = robot
        leg.state = r.state
        leg.start = r.leg_start
        leg.end = trial.tick
        leg.shelf = r.shelf
        leg.box = r.box
        leg.station = station
        leg.path_m = r.path_m - r.leg_path_m
        trial.legs += 1
    r.leg_start = trial.tick
    r.leg_path_m = r.path_m


@kernel
def set_goal(trial: Record, r: Record, goal: int) -> None:
    """Give the robot a new goal (-1: none); its way is planned before the tick ends."""
    r.goal = goal
    r.goal_tick = trial.tick
    r.best = 32767
    r.stall = 0
    r.detour = 0
    r.replan = 1


@kernel
def start_task(floor: Floor, motion: Motion, robot: int) -> None:
    """Send the robot for the next box of the pool, or home after its last."""
    trial = motion.trial[0]
    r = motion.robots[robot]
    if r.remaining == 0:
        r.state = RETURNING
        r.shelf = -1
        r.box = -1
        tell(motion, RETURNING_STARTED, robot, 0, 0)
        set_goal(motion.trial[0], r, floor.hall[0].shelves + motion.bays.size + robot)
        return
    r.shelf = motion.tasks[trial.tasks_given, 0]
    r.box = motion.tasks[trial.tasks_given, 1]
    trial.tasks_given += 1
    r.state = TO_SHELF
    tell(motion, LEG_STARTED, robot, r.shelf, r.box)
    set_goal(motion.trial[0], r, r.shelf)


@kernel
def finish_pick(floor: Floor, motion: Motion, robot: int) -> None:
    """Load the box, bind the robot to a station with a free bay and send it there."""
    r = motion.robots[robot]
    close_leg(motion, robot, -1)
    r.carrying = box_colour(r.box)
    r.bay = reserve_bay(motion.bays, floor.hall[0].bays, r.carrying, robot, motion.draws)
    r.station = r.bay // floor.hall[0].bays
    r.state = TO_STATION
    tell(motion, BOX_PICKED, robot, r.carrying, r.station)
    set_goal(motion.trial[0], r, floor.hall[0].shelves + r.bay)


@kernel
def finish_unload(floor: Floor, motion: Motion, robot: int) -> None:
    """Count the box as delivered and go on."""
    r = motion.robots[robot]
    close_leg(motion, robot, r.station)
    tell(motion, BOX_DELIVERED, robot, r.carrying, r.station)
    r.carrying = -1
    r.station = -1
    r.remaining -= 1
    r.delivered += 1
    motion.trial[0].delivered += 1
    start_task(floor, motion, robot)


@kernel
def human_serves(trial: Record, hall: Record, stations: Floats, r: Record) -> bool:
    """Say whether the human is near enough for the waiting robot to be unloaded."""
    reach = hall.unload_m
    if hall.by_station == 1:
        dx = trial.x - stations[r.station, 0]
        dy = trial.y - stations[r.station, 1]
        return bool(-reach <= dx <= reach and -reach <= dy <= reach)
    dx = trial.x - r.x
    dy = trial.y - r.y
    return bool(dx * dx + dy * dy <= reach * reach)


@kernel
def arrive(floor: Floor, motion: Motion, robot: int) -> None:
    """Start what is to be done at the goal that the robot stands on."""
    r = motion.robots[robot]
    close_leg(motion, robot, r.station)
    if r.state == TO_SHELF:
        r.state = PICKING
        r.timer = floor.hall[0].pick_ticks
    elif r.state == TO_STATION:
        r.state = WAITING
        r.wait_ticks = 0
        tell(motion, WAIT_STARTED, robot, r.station, 0)
    else:
        r.state = HOME_STATE
        r.done_tick = motion.trial[0].tick
        motion.trial[0].home += 1
        tell(motion, HOME_REACHED, robot, 0, 0)
    set_goal(motion.trial[0], r, -1)


@kernel
def start_unload(motion: Motion, robot: int) -> None:
    """End the wait: the human is here."""
    r = motion.robots[robot]
    close_leg(motion, robot, r.station)
    r.waited_ticks += r.wait_ticks
    r.wait_ticks = 0
    r.state = UNLOADING
    tell(motion, UNLOAD_STARTED, robot, r.station, 0)


@kernel
def something_ends(
    trial: Record, hall: Record, r: Record, fields: npt.NDArray[np.int16], stations: Floats
) -> bool:
    """Advance the clocks of a robot's state by one tick; say whether the state ends now."""
    if r.state == WAITING:
        r.wait_ticks += 1
        return bool(human_serves(trial, hall, stations, r))
    if r.state == PICKING or r.state == UNLOADING:
        r.timer -= 1
        return bool(r.timer == 0)
    return bool(r.state != HOME_STATE and r.mode == STANDING and fields[r.goal, r.tail] == 0)


@kernel
def change_state(floor: Floor, motion: Motion, robot: int) -> None:
    """Go on to what follows in the robot's life."""
    r = motion.robots[robot]
    if r.state == PICKING:
        finish_pick(floor, motion, robot)
    elif r.state == WAITING:
        start_unload(motion, robot)
        r.timer = floor.hall[0].unload_ticks
    elif r.state == UNLOADING:
        finish_unload(floor, motion, robot)
    else:
        arrive(floor, motion, robot)


@kernel
def mouth_covered(
    trial: Record, cells: Records, goals: npt.NDArray[np.int32], r: Record, stride: int
) -> bool:
    """Say whether the human covers the mouth of the bay or home it is in or must enter."""
    cell = r.tail
    if cells[cell].kind == SHARED:
        cell = goals[r.goal, 0]
        if cells[cell].kind == SHARED:
            return False
    for d in range(4):
        mouth = cell + neighbour_offset(d, stride)
        if cells[mouth].kind == SHARED:
            return bool(human_gap2(trial, cells, mouth) < ZONE2)
    return False


@kernel
def watch_progress(
    trial: Record, cells: Records, goals: npt.NDArray[np.int32], r: Record, left: int, stride: int
) -> None:
    """Keep the stall clock: ticks without a new minimum of `left`, the shortest remaining path."""
    if left < r.best:
        r.best = left
        r.stall = 0
    elif mouth_covered(trial, cells, goals, r, stride):
        r.blocked += 1
    else:
        r.stall += 1
        r.longest_stall = max(r.longest_stall, r.stall)
