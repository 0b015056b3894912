"""What the simulated worker believes of each robot and station, and how a look changes it.

An avatar or direct sight gives the place, a ribbon the destination, a ghost the direction, a
balloon that somebody waits. The belief, not the truth, is what the worker acts on [our choice].
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from study.ar.display_kernels import Shown
from study.people.looking import VIEW, Draws, chance, elements_in_view, in_sight, in_view
from study.people.parameters import as_record
from study.people.walking import seed_draws
from study.warehouse.halls import CELL_M, COLOURS, TICK_HZ
from study.warehouse.kernels import kernel
from study.warehouse.layout import Layout
from study.warehouse.state import HOME_STATE, UNLOADING, WAITING, Floor, Motion

NEVER = -(1 << 30)
UNKNOWN, WAITS, ARRIVES, BUSY, GONE = range(5)
GOING, SERVING, THINKING = range(3)
RIBBON = 4

BELIEF = np.dtype(
    [
        ("kind", "i4"), ("first", "i4"), ("second", "i4"), ("due", "i4"), ("noticed", "i4"),
        ("bay", "i4"),
    ],
    align=True,
)  # fmt: skip
"""Of one robot. `first`, `second`: station and a possible other one (-1); `due`: tick of arrival,
or until when it is busy; `noticed`: tick of the last look that saw it; `bay`: where it waits."""

PLACE = np.dtype(
    [("visited", "i4"), ("lit", "i4"), ("noticed", "i4"), ("hits", "f8"), ("tries", "f8")],
    align=True,
)  # fmt: skip
"""Of one station. `visited`: tick of the last visit; `lit`: since when its balloon has been on, -1
off; `noticed`: tick at which the balloon was last seen; `hits`, `tries`: what balloons came to."""

MIND = np.dtype(
    [
        ("phase", "i4"), ("station", "i4"), ("until", "i4"), ("items", "i4"), ("balloon", "i4"),
        ("onset", "i4"), ("knows", "i4"),
    ],
    align=True,
)  # fmt: skip
"""`until`: tick at which a pause ends; `items`: things in view at the last look; `balloon`: 1 when
walking to a balloon; `onset`: 1 if a balloon counts only when it came on after the last visit;
`knows`: 1 for the oracle, whose beliefs are the truth."""


class Memory(NamedTuple):
    """Everything the worker carries with it between ticks."""

    mind: npt.NDArray[np.void]  # [1] of MIND
    beliefs: npt.NDArray[np.void]  # [N] of BELIEF
    places: npt.NDArray[np.void]  # [S] of PLACE
    views: npt.NDArray[np.void]  # [1] of VIEW
    skill: npt.NDArray[np.void]  # [1] the parameters
    draws: Draws  # [1]
    sights: npt.NDArray[np.uint8]  # [N] seen directly in the present look


@kernel
def goal_cell(floor: Floor, motion: Motion, k: int) -> int:
    """Return a cell of the robot's goal, or the cell it stands in."""
    goal = motion.robots[k].goal
    return int(floor.goals[goal, 0] if goal >= 0 else motion.robots[k].tail)


@kernel
def seconds_left(floor: Floor, motion: Motion, k: int) -> float:
    """Return the driving time left to the robot's goal, as its drawn path tells."""
    r = motion.robots[k]
    if r.goal < 0:
        return 0.0
    step_s = CELL_M / (floor.hall[0].robot_step_m * TICK_HZ)
    return float(floor.fields[r.goal, r.tail] * step_s)


@kernel
def believe(floor: Floor, motion: Motion, memory: Memory, k: int, told: int) -> None:
    """Change the belief about robot k, of which the elements `told` (mask) or itself was noticed.

    That it stands in a bay, carries a box or is being unloaded can be seen of robot and avatar.
    """
    r = motion.robots[k]
    b = memory.beliefs[k]
    skill = memory.skill[0]
    tick = motion.trial[0].tick
    b.noticed = tick
    b.second = -1
    left_s = seconds_left(floor, motion, k)
    if r.state == WAITING:
        b.kind, b.first, b.due, b.bay = WAITS, r.station, tick, r.bay
        return
    if r.state == HOME_STATE:
        b.kind = GONE
        return
    if r.carrying < 0 or r.state == UNLOADING:
        b.kind = BUSY
        b.due = tick + int(skill.cycle_s * TICK_HZ)
        return
    b.kind = ARRIVES
    b.due = tick + int(left_s * TICK_HZ)
    b.bay = r.bay
    near = left_s * floor.hall[0].robot_step_m * TICK_HZ <= skill.last_leg_m
    if told & 12 or near or (told & 2 and chance(memory.draws) < skill.ghost_tells):
        b.first = r.station
    else:
        stations = motion.bays.size // floor.hall[0].bays
        b.first = (r.carrying % COLOURS) % stations
        b.second = (b.first + 1) % stations


@kernel
def know_all(floor: Floor, motion: Motion, memory: Memory) -> None:
    """Believe the truth about every robot; there is nothing to read."""
    memory.mind[0].items = 0
    for k in range(motion.robots.size):
        believe(floor, motion, memory, k, RIBBON)


@kernel
def see_dot(floor: Floor, motion: Motion, memory: Memory, k: int) -> None:
    """Take from a dot on the map its place: standing in a bay it waits, else it is busy a while."""
    r = motion.robots[k]
    b = memory.beliefs[k]
    tick = motion.trial[0].tick
    b.noticed = tick
    if r.state == WAITING:
        b.kind, b.first, b.second, b.due, b.bay = WAITS, r.station, -1, tick, r.bay
    elif b.kind == UNKNOWN or b.kind == WAITS:
        b.kind = BUSY
        b.due = tick + 5 * TICK_HZ


@kernel
def count_items(floor: Floor, motion: Motion, memory: Memory, shown: Shown) -> int:
    """Return how many things are in view: AR elements, and robots seen directly."""
    view = memory.views[0]
    items = 0
    for k in range(motion.robots.size):
        items += memory.sights[k]
        cell = motion.cells[goal_cell(floor, motion, k)]
        mask = elements_in_view(view, motion.robots, k, shown.robots[k], cell.x, cell.y)
        items += (mask & 1) + (mask >> 1 & 1) + (mask >> 2 & 1) + (mask >> 3 & 1)
        if shown.overlays[0] & 1:
            items += 1
        if shown.overlays[0] & 2 and not in_view(view, motion.robots[k].x, motion.robots[k].y):
            items += 1
    for n in range(shown.stations.size):
        if shown.stations[n] and in_view(view, floor.stations[n, 0], floor.stations[n, 1]):
            items += 1
    return items


@kernel
def look(floor: Floor, motion: Motion, memory: Memory, shown: Shown, factor: float) -> None:
    """Look once with the present view; each thing in it is noticed or not on its own."""
    if memory.mind[0].knows == 1:
        know_all(floor, motion, memory)
        return
    view = memory.views[0]
    skill = memory.skill[0]
    robots = motion.robots
    stride = floor.hall[0].stride
    for k in range(robots.size):
        memory.sights[k] = in_sight(view, motion.cells, robots[k].x, robots[k].y, stride)
    items = count_items(floor, motion, memory, shown)
    memory.mind[0].items = items
    p = skill.notice * skill.clutter_items / (skill.clutter_items + items) * factor
    for k in range(robots.size):
        cell = motion.cells[goal_cell(floor, motion, k)]
        mask = elements_in_view(view, robots, k, shown.robots[k], cell.x, cell.y)
        seen = memory.sights[k] == 1 and chance(memory.draws) < p
        told = 0
        for bit in range(4):
            if mask >> bit & 1 and chance(memory.draws) < p:
                told |= 1 << bit
        if seen or told:
            believe(floor, motion, memory, k, told)
        elif shown.overlays[0] & 1 and chance(memory.draws) < p:
            see_dot(floor, motion, memory, k)
    look_for_balloons(floor, memory, shown, p, motion.trial[0].tick)


@kernel
def look_for_balloons(floor: Floor, memory: Memory, shown: Shown, p: float, tick: int) -> None:
    """Keep track of when balloons came on, and notice those in view."""
    for n in range(shown.stations.size):
        place = memory.places[n]
        if not shown.stations[n]:
            place.lit = -1
            continue
        if place.lit < 0:
            place.lit = tick
        here = in_view(memory.views[0], floor.stations[n, 0], floor.stations[n, 1])
        if here and chance(memory.draws) < p:
            place.noticed = tick


@kernel
def forget(memory: Memory, tick: int) -> None:
    """Keep what was noticed lately, and of older beliefs only the newest few."""
    skill = memory.skill[0]
    fresh = tick - int(skill.memory_fresh_s * TICK_HZ)
    beliefs = memory.beliefs
    for k in range(beliefs.size):
        b = beliefs[k]
        if b.noticed >= fresh or b.kind == UNKNOWN or b.kind == GONE:
            continue
        newer = 0
        for m in range(beliefs.size):
            o = beliefs[m]
            old = o.noticed < fresh and o.kind != UNKNOWN and o.kind != GONE
            if old and (o.noticed > b.noticed or (o.noticed == b.noticed and m < k)):
                newer += 1
        if newer >= skill.memory_robots:
            b.kind = UNKNOWN
    for k in range(beliefs.size):
        if beliefs[k].kind == BUSY and beliefs[k].due <= tick:
            beliefs[k].kind = UNKNOWN


def new_memory(
    layout: Layout, seed: int, values: Mapping[str, float], *, knows: bool = False
) -> Memory:
    """Return the memory before the first look: nothing known, all stations alike.

    `values`: the worker's parameters. `knows`: for the oracle, who also judges distances exactly.
    """
    robots, stations = layout.spec.robots, len(layout.stations)
    skill = dict(values)
    skill["half_view_cosine"] = math.cos(math.radians(skill["half_view_deg"]))
    skill["hick_s"] = skill["hick_s_per_bit"] * math.log2(stations + 1)
    if knows:
        skill["distance_cv"] = 0.0
    memory = Memory(
        mind=np.zeros(1, dtype=MIND),
        beliefs=np.zeros(robots, dtype=BELIEF),
        places=np.zeros(stations, dtype=PLACE),
        views=np.zeros(1, dtype=VIEW),
        skill=as_record(skill),
        draws=seed_draws(seed),
        sights=np.zeros(robots, dtype=np.uint8),
    )
    memory.mind["phase"] = THINKING
    memory.mind["onset"] = 1
    memory.mind["knows"] = knows
    memory.beliefs["first"] = memory.beliefs["second"] = -1
    memory.beliefs["noticed"] = NEVER
    memory.places["visited"] = -int(skill["start_s"] * TICK_HZ)
    memory.places["noticed"] = NEVER
    memory.places["lit"] = -1
    memory.places["hits"] = 2.0
    memory.places["tries"] = 3.0
    memory.views["sight_m"] = skill["sight_m"]
    return memory
