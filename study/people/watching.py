"""What the expert `person` takes in from its picture: the worker's view, or one from above.

Everything here is seen: robots in direct sight, AR elements in the picture, the boxes carried, the
length of the way still to go. From the worker's view a robot behind a shelf is known only by its
avatar or its ribbon [paper: a footnote tells of this]; from above no shelf hides anything.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from study.ar.display_kernels import Shown
from study.people.beliefs import WAITS, Memory, believe, goal_cell
from study.people.believer import aim_view, rough_normal
from study.people.looking import elements_in_view, in_sight, in_view
from study.warehouse.halls import TICK_HZ
from study.warehouse.kernels import kernel
from study.warehouse.state import Floor, Motion

LIVE = 1

SEEN = np.dtype(
    [
        ("known", "i4"), ("direct", "i4"), ("placed", "i4"), ("crowd", "i4"), ("longest", "i4"),
        ("since", "i4"), ("away_m", "f8"), ("left_s", "f8"),
    ],
    align=True,
)  # fmt: skip
"""Of one robot in the present picture. `known`: it can be judged; `direct`: the worker sees it
itself; `placed`: its place is known; `crowd`: others whose place is known close to it; `longest`: 1
if it was seen waiting before all waiting ones among them; `since`: tick at which it was first seen
waiting; `away_m`: distance from the worker, as judged; `left_s`: time to its arrival, as judged."""

SPOT = np.dtype([("known", "i4"), ("away_m", "f8")], align=True)
"""Of one station: whether it is in the picture, and how far away the worker is, as judged."""


@kernel
def guess(memory: Memory, value: float) -> float:
    """Return a value as somebody judges it by eye."""
    return float(value * max(0.4, 1.0 + memory.skill[0].distance_cv * rough_normal(memory)))


@kernel
def distance(x: float, y: float, other_x: float, other_y: float) -> float:
    """Return the distance of two places in metres."""
    return float(np.sqrt((x - other_x) * (x - other_x) + (y - other_y) * (y - other_y)))


@kernel
def open_eyes(
    floor: Floor, motion: Motion, memory: Memory, eyes: npt.NDArray[np.void], stopped: int
) -> None:
    """Point both views: the worker's in `memory`, and the person's, which sees all from above."""
    aim_view(motion.trial[0], memory, floor.cosines, stopped == 1)
    worker = memory.views[0]
    eye = eyes[0]
    eye.x, eye.y = worker.x, worker.y
    eye.look_x, eye.look_y = worker.look_x, worker.look_y
    eye.sight_m = worker.sight_m
    eye.cosine = -2.0 if eye.through == 1 else worker.cosine


@kernel
def watch(
    floor: Floor,
    motion: Motion,
    memory: Memory,
    shown: Shown,
    eyes: npt.NDArray[np.void],
    seen: npt.NDArray[np.void],
    spots: npt.NDArray[np.void],
    stopped: int,
) -> None:
    """Look at the picture once. `stopped`: 1 while the worker stands and looks around.

    Beliefs in `memory` take what was seen; `eyes`: [1] of VIEW, `through` for the picture from
    above; `seen`: [N] of SEEN; `spots`: [S] of SPOT.
    """
    trial = motion.trial[0]
    stride = floor.hall[0].stride
    open_eyes(floor, motion, memory, eyes, stopped)
    eye = eyes[0]
    for k in range(seen.size):
        r = motion.robots[k]
        s = seen[k]
        s.direct = in_sight(memory.views[0], motion.cells, r.x, r.y, stride)
        goal = motion.cells[goal_cell(floor, motion, k)]
        mask = elements_in_view(eye, motion.robots, k, shown.robots[k], goal.x, goal.y)
        s.placed = in_sight(eye, motion.cells, r.x, r.y, stride) or mask & LIVE != 0
        s.known = s.placed == 1 or mask != 0
        if s.known == 0:
            continue
        waited = memory.beliefs[k].kind == WAITS
        believe(floor, motion, memory, k, mask)
        if memory.beliefs[k].kind == WAITS and not waited:
            s.since = trial.tick
        s.away_m = guess(memory, distance(r.x, r.y, trial.x, trial.y))
        s.left_s = guess(memory, max(0.0, (memory.beliefs[k].due - trial.tick) / TICK_HZ))
    for n in range(spots.size):
        x, y = floor.stations[n, 0], floor.stations[n, 1]
        spots[n].known = in_view(eye, x, y)
        spots[n].away_m = guess(memory, distance(x, y, trial.x, trial.y))


@kernel
def count_crowds(
    motion: Motion, memory: Memory, seen: npt.NDArray[np.void], crowd_m: float
) -> None:
    """Set how many others are close to each robot, and who of those waits longest."""
    robots = motion.robots
    for k in range(seen.size):
        s = seen[k]
        s.crowd = 0
        s.longest = 1
        for m in range(seen.size):
            if m == k or s.placed == 0 or seen[m].placed == 0:
                continue
            if distance(robots[k].x, robots[k].y, robots[m].x, robots[m].y) > crowd_m:
                continue
            s.crowd += 1
            older = seen[m].since < s.since or (seen[m].since == s.since and m < k)
            if memory.beliefs[m].kind == WAITS and older:
                s.longest = 0
