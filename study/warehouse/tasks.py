"""Which box a robot fetches next, and to which station it carries it.

The pool holds 12 boxes per shelf; box n of a shelf has colour n mod 4. A seeded generator draws a
robot's next task (paper: the pool and the seeded draw; the authors' simulator: 12 boxes, colours
and the pair of stations). Our choice: of a colour's two stations the one with fewer robots bound
for it is taken, ties by a seeded draw, and a bay is reserved with it, so that no robot ever queues.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
import numpy.typing as npt

from study.warehouse.halls import BOXES_PER_SHELF, COLOURS
from study.warehouse.kernels import kernel
from study.warehouse.layout import Layout

Tasks = npt.NDArray[np.int32]
MASK64 = (1 << 64) - 1
GOLDEN = 0x9E3779B97F4A7C15


class Draws:
    """A stream of random numbers that no library version can change (splitmix64)."""

    def __init__(self, seed: int) -> None:
        self.state = seed & MASK64

    def next(self) -> int:
        """Return the next 64 random bits."""
        self.state = (self.state + GOLDEN) & MASK64
        z = self.state
        z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & MASK64
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & MASK64
        return z ^ (z >> 31)

    def below(self, count: int) -> int:
        """Return a whole number from 0 to count - 1."""
        return (self.next() * count) >> 64


class TaskSource(Protocol):
    """Draws a trial's tasks; held to its promises by `examine_tasks`."""

    def draw_tasks(self, layout: Layout, seed: int) -> Tasks:
        """Return int32[boxes_total, 2] of (shelf, box): row n is the n-th task handed out."""
        ...


class PooledTasks:
    """Draws tasks from the pool of all stored boxes without replacement, each equally likely."""

    def draw_tasks(self, layout: Layout, seed: int) -> Tasks:
        """Return the first boxes_total entries of a seeded shuffle of the pool."""
        draws = Draws(seed)
        pool = list(range(len(layout.shelf_cells) * BOXES_PER_SHELF))
        chosen = []
        for n in range(layout.spec.boxes_total):
            m = n + draws.below(len(pool) - n)
            pool[n], pool[m] = pool[m], pool[n]
            chosen.append(divmod(pool[n], BOXES_PER_SHELF))
        return np.array(chosen, dtype=np.int32)


def examine_tasks(source: TaskSource, layout: Layout, seed: int) -> None:
    """Run the contract's examination. Errors: BrokenPromise saying which promise was broken."""
    tasks = source.draw_tasks(layout, seed)
    shape = (layout.spec.boxes_total, 2)
    _promise(tasks.shape == shape, f"tasks have shape {tasks.shape}, wanted {shape}")
    _promise(tasks.dtype == np.int32, f"tasks are {tasks.dtype}, wanted int32")
    _promise(len({tuple(row) for row in tasks.tolist()}) == len(tasks), "a box comes twice")
    shelves, boxes = tasks[:, 0], tasks[:, 1]
    _promise(bool(((shelves >= 0) & (shelves < len(layout.shelf_cells))).all()), "no such shelf")
    _promise(bool(((boxes >= 0) & (boxes < BOXES_PER_SHELF)).all()), "no such box")
    again = source.draw_tasks(layout, seed)
    _promise(bool((again == tasks).all()), "the same seed drew other tasks")


class BrokenPromise(AssertionError):
    """A task source does not keep its contract."""


def _promise(kept: bool, sentence: str) -> None:
    if not kept:
        raise BrokenPromise(sentence)


@kernel
def box_colour(box: int) -> int:
    """Return the colour 0 red, 1 green, 2 blue, 3 yellow of a shelf's box."""
    return box % COLOURS


@kernel
def next_draw(stream: npt.NDArray[np.uint64]) -> int:
    """Advance the one-entry splitmix64 state `stream`; return 63 random bits."""
    stream[0] = stream[0] + np.uint64(GOLDEN)
    z = stream[0]
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return int((z ^ (z >> np.uint64(31))) >> np.uint64(1))


@kernel
def count_bound(holders: npt.NDArray[np.int16], station: int, bays: int) -> int:
    """Return how many bays of `station` are reserved or occupied."""
    count = 0
    for n in range(station * bays, (station + 1) * bays):
        if holders[n] >= 0:
            count += 1
    return count


@kernel
def reserve_bay(
    holders: npt.NDArray[np.int16],
    bays: int,
    colour: int,
    robot: int,
    stream: npt.NDArray[np.uint64],
) -> int:
    """Bind `robot`, carrying a box of `colour`, to a station's bay; return the bay's index.

    `holders`: int16[stations * bays], -1 where free, bay n of station s at s * bays + n; changed.
    """
    stations = holders.size // bays
    first = colour % stations
    second = (colour + 1) % stations
    at_first = count_bound(holders, first, bays)
    at_second = count_bound(holders, second, bays)
    station = first
    if at_second < at_first or (at_second == at_first and next_draw(stream) & 1 == 1):
        station = second
    for n in range(station * bays, (station + 1) * bays):
        if holders[n] < 0:
            holders[n] = robot
            return n
    return -1
