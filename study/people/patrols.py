"""Three simple workers that know everything, for tests and for reference lines.

cyclic    walks the stations in order and serves whoever waits at the one it has come to
wanderer  serves the nearest waiting robot, and strolls between the shelves when nobody waits
blocker   walks into some robot's way, stands there for a while, serves one robot, and again

Each is a pure function of the world and its own small memory, and moves by real input frames.
All of it is our choice; the authors' simulator has a worker like `cyclic`.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from study.people.walking import (
    NOWHERE,
    OWN_WAY,
    Field,
    Legs,
    cell_of,
    fill_way,
    note_frame,
    seed_draws,
    walk,
)
from study.warehouse.kernels import kernel
from study.warehouse.planning import human_gap2
from study.warehouse.routes import SHARED
from study.warehouse.state import RUNNING, WAITING, Floor, Motion, Record
from study.warehouse.step import step_world
from study.warehouse.tasks import next_draw

PATROLS = ("cyclic", "wanderer", "blocker")
CYCLIC, WANDERER, BLOCKER = range(3)
STROLLING, SERVING, GOING, BLOCKING = range(4)
VISIT_CELLS = 3
MOVE_ON_M = 2.0
STROLL_TICKS = 300
APPROACH_TICKS = 240
PATH_AHEAD_CELLS = 6


@kernel
def nearest_waiting(floor: Floor, motion: Motion, cell: int, station: int) -> int:
    """Return the goal row of the nearest bay with a waiting robot (-1: none).

    `station`: only there; -1 anywhere.
    """
    best = -1
    for k in range(motion.robots.size):
        r = motion.robots[k]
        if r.state != WAITING or (station >= 0 and r.station != station):
            continue
        goal = floor.hall[0].shelves + r.bay
        if best < 0 or floor.fields[goal, cell] < floor.fields[best, cell]:
            best = goal
    return best


@kernel
def guide_cyclic(floor: Floor, motion: Motion, walker: Record, cell: int) -> None:
    """Serve the station that was reached until nobody waits there, then go to the next."""
    bays = floor.hall[0].bays
    middle = floor.hall[0].shelves + walker.station * bays + bays // 2
    if walker.phase == STROLLING and floor.fields[middle, cell] <= VISIT_CELLS:
        walker.phase = SERVING
    if walker.phase == SERVING:
        goal = nearest_waiting(floor, motion, cell, walker.station)
        if goal >= 0:
            walker.goal = goal
            return
        walker.phase = STROLLING
        walker.station = (walker.station + 1) % (motion.bays.size // bays)
        middle = floor.hall[0].shelves + walker.station * bays + bays // 2
    walker.goal = middle


@kernel
def guide_wanderer(
    floor: Floor, motion: Motion, walker: Record, cell: int, draws: npt.NDArray[np.uint64]
) -> None:
    """Go to the nearest waiting robot, else to some shelf, and stay there until the time is up."""
    goal = nearest_waiting(floor, motion, cell, -1)
    if goal >= 0:
        walker.goal = goal
        walker.until = 0
        return
    tick = motion.trial[0].tick
    if tick >= walker.until:
        walker.target = next_draw(draws) % floor.hall[0].shelves
        walker.until = tick + STROLL_TICKS
    walker.goal = walker.target if floor.fields[walker.target, cell] > 0 else NOWHERE


@kernel
def choose_block(motion: Motion, walker: Record, draws: npt.NDArray[np.uint64]) -> bool:
    """Choose a cell some way ahead on a random robot's path, but not here: it must move on."""
    robots = motion.robots
    trial = motion.trial[0]
    first = next_draw(draws) % robots.size
    for n in range(robots.size):
        r = robots[(first + n) % robots.size]
        ahead = min(r.plan_at + 1 + next_draw(draws) % PATH_AHEAD_CELLS, r.plan_length - 1)
        while ahead > 0 and motion.cells[motion.plans[r.index, ahead]].kind != SHARED:
            ahead -= 1
        if ahead <= r.plan_at:
            continue
        target = motion.plans[r.index, ahead]
        if human_gap2(trial, motion.cells, target) > MOVE_ON_M * MOVE_ON_M:
            walker.target = target
            return True
    return False


@kernel
def guide_blocker(
    floor: Floor,
    motion: Motion,
    walker: Record,
    cell: int,
    way: Field,
    draws: npt.NDArray[np.uint64],
) -> None:
    """Walk into a robot's way, stand there for 2 to 14 s, serve one robot, and again."""
    tick = motion.trial[0].tick
    if walker.phase == GOING and (way[cell] == 0 or tick >= walker.until):
        walker.phase = BLOCKING
        walker.goal = NOWHERE
        walker.until = tick + 60 + next_draw(draws) % 360
    if walker.phase == BLOCKING and tick >= walker.until:
        walker.phase = SERVING
        walker.target = motion.trial[0].delivered
    if walker.phase == SERVING:
        walker.goal = nearest_waiting(floor, motion, cell, -1)
        if walker.goal < 0 or motion.trial[0].delivered > walker.target:
            walker.phase = STROLLING
    if walker.phase == STROLLING:
        if not choose_block(motion, walker, draws):
            walker.target = floor.goals[next_draw(draws) % floor.hall[0].shelves, 0]
        fill_way(motion.cells, way, motion.queue, walker.target, floor.hall[0].stride)
        walker.goal = OWN_WAY
        walker.phase = GOING
        walker.until = tick + APPROACH_TICKS


@kernel
def decide_step(
    floor: Floor,
    motion: Motion,
    patrol: int,
    walkers: npt.NDArray[np.void],
    ways: npt.NDArray[np.int16],
    draws: npt.NDArray[np.uint64],
) -> None:
    """Set the walker's keys and yaw for the coming tick. `ways`: int16[2, C] of its own."""
    trial = motion.trial[0]
    walker = walkers[0]
    cell = cell_of(motion.cells, trial.x, trial.y, floor.hall[0].stride)
    if patrol == CYCLIC:
        guide_cyclic(floor, motion, walker, cell)
    elif patrol == WANDERER:
        guide_wanderer(floor, motion, walker, cell, draws)
    else:
        guide_blocker(floor, motion, walker, cell, ways[0], draws)
    walk(
        trial, motion.cells, motion.robots, floor.fields, ways[0], ways[1], motion.queue,
        walkers[0], floor.hall[0].stride, floor.cosines,
    )  # fmt: skip


@kernel
def run_patrol(
    floor: Floor,
    motion: Motion,
    patrol: int,
    walkers: npt.NDArray[np.void],
    ways: npt.NDArray[np.int16],
    draws: npt.NDArray[np.uint64],
    record: npt.NDArray[np.int32],
) -> int:
    """Run the trial to its end with a patrol; return the ticks. `record`: see `note_frame`."""
    frames = np.zeros((1, 2), dtype=np.int32)
    trial = motion.trial[0]
    while trial.status == RUNNING:
        decide_step(floor, motion, patrol, walkers, ways, draws)
        note_frame(walkers[0], trial.tick, frames, record)
        step_world(floor, motion, frames, 1)
    return int(trial.tick)


class Patrol:
    """One worker's memory, for worlds that are stepped from outside: `next_frame` per tick."""

    def __init__(self, name: str, floor: Floor, motion: Motion, seed: int) -> None:
        self.number = PATROLS.index(name)
        self.floor = floor
        self.motion = motion
        self.legs = Legs(motion)
        self.draws = seed_draws(seed)

    def next_frame(self) -> tuple[int, int]:
        """Return the keys and yaw with which this worker answers the world's present state."""
        own = (self.legs.walkers, self.legs.ways, self.draws)
        decide_step(self.floor, self.motion, self.number, *own)
        return self.legs.frame

    def run(self, record: npt.NDArray[np.int32]) -> int:
        """Run the trial to its end inside compiled code; return the ticks."""
        arrays = (self.legs.walkers, self.legs.ways, self.draws, record)
        return int(run_patrol(self.floor, self.motion, self.number, *arrays))
