"""The simulated worker `believer`: acts on what it believes, not on what is true [our choice].

It looks once a second while it walks and all around where it stops, goes where belief per walking
second is highest, and pays for each decision with a base time, Hick's law over the stations and a
search among the things in view. A prior that grows since the last visit makes it patrol; no rule
knows which condition is displayed.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from study.ar.display_kernels import Shown
from study.people.beliefs import (
    ARRIVES,
    BUSY,
    GOING,
    SERVING,
    THINKING,
    UNKNOWN,
    WAITS,
    Memory,
    forget,
    know_all,
    look,
)
from study.people.looking import chance
from study.people.walking import NOWHERE, cell_of
from study.warehouse.halls import CELL_M, TICK_HZ
from study.warehouse.kernels import kernel
from study.warehouse.state import WAITING, Floor, Motion, Record

VISIT_CELLS = 3
ASIDE_M = 1.3


@kernel
def aim_view(trial: Record, memory: Memory, cosines: npt.NDArray[np.float64], around: bool) -> None:
    """Point the view where the human looks; all around when it has stopped."""
    view = memory.views[0]
    index = trial.yaw >> 4
    view.x = trial.x
    view.y = trial.y
    view.look_x = cosines[index]
    view.look_y = cosines[(index - 1024) & 4095]
    view.cosine = -1.0 if around else memory.skill[0].half_view_cosine


@kernel
def value_of(floor: Floor, motion: Motion, memory: Memory, station: int, cell: int) -> float:
    """Return the believed worth of going to a station, per second of the way and the waiting."""
    skill = memory.skill[0]
    tick = motion.trial[0].tick
    hall = floor.hall[0]
    middle = hall.shelves + station * hall.bays + hall.bays // 2
    walk_s = floor.fields[middle, cell] * CELL_M / (hall.human_step_m * TICK_HZ)
    walk_s *= max(0.4, 1.0 + skill.distance_cv * rough_normal(memory))
    latest = tick + int((walk_s + skill.stay_s) * TICK_HZ)
    place = memory.places[station]
    worth = 0.0
    wait_s = walk_s + skill.stay_s
    unknown = 0
    for k in range(memory.beliefs.size):
        b = memory.beliefs[k]
        if b.kind == UNKNOWN:
            unknown += 1
        if b.kind != WAITS and b.kind != ARRIVES:
            continue
        if (b.first == station or b.second == station) and b.due <= latest:
            worth += 0.5 if b.second >= 0 else 1.0
            wait_s = min(wait_s, max(0.0, (b.due - tick) / TICK_HZ - walk_s))
    since_s = (tick - place.visited) / TICK_HZ
    prior = unknown * since_s / (since_s + skill.revisit_s)
    if balloon_counts(memory, station, tick):
        worth = max(worth, place.hits / place.tries)
    if worth == 0.0:
        wait_s = 0.0
    return float((worth + prior) / (walk_s + wait_s + skill.turn_s))


@kernel
def rough_normal(memory: Memory) -> float:
    """Return a number that is nearly standard normal, without logarithms."""
    total = -6.0
    for _ in range(12):
        total += chance(memory.draws)
    return total


@kernel
def balloon_counts(memory: Memory, station: int, tick: int) -> bool:
    """Say whether a balloon noticed lately still means that somebody waits."""
    place = memory.places[station]
    if place.lit < 0 or tick - place.noticed > memory.skill[0].balloon_s * TICK_HZ:
        return False
    return bool(memory.mind[0].onset == 0 or place.lit > place.visited)


@kernel
def choose(floor: Floor, motion: Motion, memory: Memory, cell: int, keep: float) -> None:
    """Choose the station of highest worth; another than the present must be `keep` times better."""
    mind = memory.mind[0]
    best = mind.station
    best_worth = keep * value_of(floor, motion, memory, best, cell) if keep > 0.0 else -1.0
    for station in range(memory.places.size):
        if keep > 0.0 and station == mind.station:
            continue
        worth = value_of(floor, motion, memory, station, cell)
        if worth > best_worth:
            best_worth = worth
            best = station
    if mind.knows == 1 and best_worth <= 0.0:
        best = next_arrival(memory, mind.station)
    mind.station = best
    mind.balloon = 1 if balloon_counts(memory, best, motion.trial[0].tick) else 0


@kernel
def next_arrival(memory: Memory, here: int) -> int:
    """Return the station of the robot that arrives first; `here` if none is on its way."""
    station = here
    first = 1 << 30
    for k in range(memory.beliefs.size):
        b = memory.beliefs[k]
        if b.kind == ARRIVES and b.due < first:
            first = b.due
            station = b.first
    return station


@kernel
def serve(floor: Floor, motion: Motion, memory: Memory, walker: Record, cell: int) -> bool:
    """Go to the nearest robot believed to wait at this station, or make room for one that comes.

    Returns whether to stay here.
    """
    tick = motion.trial[0].tick
    skill = memory.skill[0]
    station = memory.mind[0].station
    best = NOWHERE
    aside = NOWHERE
    stay = False
    for k in range(memory.beliefs.size):
        b = memory.beliefs[k]
        if b.first != station and b.second != station:
            continue
        if b.kind == WAITS:
            goal = floor.hall[0].shelves + b.bay
            if best < 0 or floor.fields[goal, cell] < floor.fields[best, cell]:
                best = goal
        elif b.kind == ARRIVES and b.second < 0:
            late = tick - b.due
            if -skill.stay_s * TICK_HZ <= late <= skill.stay_s * TICK_HZ:
                stay = True
                if best == NOWHERE and stands_before(floor, motion, b.bay):
                    aside = nearest_shelf(floor, cell)
    walker.goal = best if best != NOWHERE else aside
    return stay or best != NOWHERE


@kernel
def stands_before(floor: Floor, motion: Motion, bay: int) -> bool:
    """Say whether the human is in the way of a robot that comes to this bay or leaves it."""
    trial = motion.trial[0]
    place = motion.cells[floor.goals[floor.hall[0].shelves + bay, 0]]
    dx = place.x - trial.x
    dy = place.y - trial.y
    return bool(dx * dx + dy * dy < ASIDE_M * ASIDE_M)


@kernel
def nearest_shelf(floor: Floor, cell: int) -> int:
    """Return the nearest shelf's goal row: towards it the way leads off the bays' mouths."""
    best = 0
    for shelf in range(floor.hall[0].shelves):
        if floor.fields[shelf, cell] < floor.fields[best, cell]:
            best = shelf
    return best


@kernel
def note_unloading(floor: Floor, motion: Motion, memory: Memory) -> None:
    """At hand the worker sees that a robot unloads, or that none is there: busy for a cycle."""
    trial = motion.trial[0]
    reach = floor.hall[0].unload_m
    for k in range(motion.robots.size):
        b = memory.beliefs[k]
        if b.kind != WAITS:
            continue
        cell = motion.cells[floor.goals[floor.hall[0].shelves + b.bay, 0]]
        dx = cell.x - trial.x
        dy = cell.y - trial.y
        if dx * dx + dy * dy <= reach * reach and motion.robots[k].state != WAITING:
            b.kind = BUSY
            b.due = trial.tick + int(memory.skill[0].cycle_s * TICK_HZ)


@kernel
def arrive(motion: Motion, memory: Memory) -> None:
    """Take note of a visit, and of whether the balloon that led here was right."""
    mind = memory.mind[0]
    place = memory.places[mind.station]
    if mind.balloon:
        place.tries += 1.0
        for k in range(memory.beliefs.size):
            b = memory.beliefs[k]
            if b.kind == WAITS and b.first == mind.station:
                place.hits += 1.0
                break
        mind.balloon = 0
    place.visited = motion.trial[0].tick


@kernel
def think(
    floor: Floor, motion: Motion, memory: Memory, shown: Shown, walker: Record, cell: int
) -> None:
    """Go on with what the worker is about: walking, serving, or making up its mind.

    While it does the last it steps off the bays' mouths, so that robots can leave.
    """
    mind = memory.mind[0]
    skill = memory.skill[0]
    tick = motion.trial[0].tick
    hall = floor.hall[0]
    if mind.phase == THINKING:
        walker.goal = NOWHERE
        for bay in range(mind.station * hall.bays, (mind.station + 1) * hall.bays):
            if stands_before(floor, motion, bay):
                walker.goal = nearest_shelf(floor, cell)
        if tick < mind.until:
            return
        choose(floor, motion, memory, cell, 0.0)
        mind.phase = GOING
    middle = hall.shelves + mind.station * hall.bays + hall.bays // 2
    if mind.phase == GOING:
        walker.goal = middle
        if floor.fields[middle, cell] > VISIT_CELLS:
            return
        mind.phase = SERVING
        aim_view(motion.trial[0], memory, floor.cosines, True)
        look(floor, motion, memory, shown, 1.0)
        arrive(motion, memory)
    note_unloading(floor, motion, memory)
    if not serve(floor, motion, memory, walker, cell):
        memory.places[mind.station].visited = tick
        mind.phase = THINKING
        cost_s = skill.decide_s + skill.hick_s + skill.search_s_per_item * mind.items
        mind.until = tick + int(cost_s * TICK_HZ)


@kernel
def act(floor: Floor, motion: Motion, memory: Memory, shown: Shown, walker: Record) -> None:
    """Look and think when it is time to."""
    trial = motion.trial[0]
    mind = memory.mind[0]
    cell = cell_of(motion.cells, trial.x, trial.y, floor.hall[0].stride)
    phase = mind.phase
    if mind.knows == 1:
        know_all(floor, motion, memory)
    if trial.tick % int(memory.skill[0].walking_look_s * TICK_HZ) == 0:
        still = phase != GOING
        aim_view(trial, memory, floor.cosines, still)
        look(floor, motion, memory, shown, 1.0 if still else memory.skill[0].walking_factor)
        forget(memory, trial.tick)
        if phase == GOING:
            choose(floor, motion, memory, cell, memory.skill[0].switch_factor)
    think(floor, motion, memory, shown, walker, cell)
