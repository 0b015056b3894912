"""How a simulated human walks: along a distance field, with real input frames.

It heads for the farthest cell ahead on its way to which the floor is clear, and when it gets
nowhere for half a second it looks for a way round the robots. Only keys and yaw come out of it: the
world moves a simulated human by the same rule as a real one.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from study.warehouse.halls import CELL_M
from study.warehouse.kernels import kernel
from study.warehouse.planning import Records
from study.warehouse.routes import SHARED, UNREACHED, WALL, fill_marked, neighbour_offset
from study.warehouse.state import Motion, Record

Field = npt.NDArray[np.int16]
Floats = npt.NDArray[np.float64]

WALKER = np.dtype(
    [
        ("x", "f8"), ("y", "f8"), ("aim_x", "f8"), ("aim_y", "f8"), ("cell", "i4"), ("still", "i4"),
        ("around", "i4"), ("goal", "i4"), ("phase", "i4"), ("until", "i4"), ("station", "i4"),
        ("target", "i4"), ("keys", "i4"), ("yaw", "i4"),
    ],
    align=True,
)  # fmt: skip
"""A walker's memory. `goal`: row of the hall's fields, OWN_WAY for `way`, NOWHERE to stand."""

OWN_WAY = -2
NOWHERE = -1
LOOK_CELLS = 6
STUCK_TICKS = 15
STUCK_M = 0.15
AROUND_TICKS = 45
NEAR_ROBOT2 = 0.62 * 0.62


@kernel
def face(dx: float, dy: float, cosines: Floats) -> int:
    """Return the yaw (u16) nearest below the direction (dx, dy), by halving; no arctangent."""
    if dy == 0.0:
        return 0 if dx >= 0.0 else 32768
    low = 0 if dy > 0.0 else 2048
    high = low + 2048
    while high - low > 1:
        middle = (low + high) >> 1
        c = cosines[middle]
        s = cosines[(middle - 1024) & 4095]
        if c * dy - s * dx >= 0.0:
            low = middle
        else:
            high = middle
    return low << 4


@kernel
def cell_of(cells: Records, x: float, y: float, stride: int) -> int:
    """Return the padded lattice cell that contains (x, y)."""
    column = int((x - cells[0].x) / CELL_M + 0.5)
    row = int((y - cells[0].y) / CELL_M + 0.5)
    return row * stride + column


@kernel
def is_clear(cells: Records, field: Field, start: int, end: int, stride: int) -> bool:
    """Say whether all cells of the rectangle spanned by two cells are floor and open in `field`."""
    row_a, row_b = start // stride, end // stride
    column_a, column_b = start % stride, end % stride
    for row in range(min(row_a, row_b), max(row_a, row_b) + 1):
        for column in range(min(column_a, column_b), max(column_a, column_b) + 1):
            cell = row * stride + column
            if cells[cell].kind != SHARED or field[cell] == WALL:
                return False
    return True


@kernel
def aim(cells: Records, field: Field, walker: Record, start: int, stride: int) -> None:
    """Set the walker's aim to the farthest of the next cells down `field` that it can walk to."""
    cell = start
    best = start
    for _ in range(LOOK_CELLS):
        step = 0
        for d in range(4):
            other = cell + neighbour_offset(d, stride)
            if field[other] < field[cell] and cells[other].kind == SHARED:
                step = other
                if (other - cell) != (cell - best):
                    break
        if step == 0 or not is_clear(cells, field, start, step, stride):
            break
        cell = step
        best = step
    walker.aim_x = cells[best].x
    walker.aim_y = cells[best].y


@kernel
def look_around(
    cells: Records, robots: Records, from_field: Field, way: Field, queue: npt.NDArray[np.int32],
    walker: Record, stride: int,
) -> bool:  # fmt: skip
    """Fill `way` with steps to where `from_field` is least, closed where robots are.

    Returns whether the walker's cell can get there.
    """
    goal = 0
    for n in range(way.size):
        if cells[n].kind == SHARED and (goal == 0 or from_field[n] < from_field[goal]):
            goal = n
    for n in range(way.size):
        way[n] = UNREACHED if cells[n].kind == SHARED else WALL
    for k in range(robots.size):
        here = cell_of(cells, robots[k].x, robots[k].y, stride)
        for row in range(-1, 2):
            for column in range(-1, 2):
                cell = here + row * stride + column
                dx = cells[cell].x - robots[k].x
                dy = cells[cell].y - robots[k].y
                if dx * dx + dy * dy < NEAR_ROBOT2:
                    way[cell] = WALL
    way[walker.cell] = UNREACHED
    if way[goal] == WALL:
        way[goal] = UNREACHED
    fill_marked(stride, np.array([goal], dtype=np.int32), way, queue, walker.cell)
    return bool(way[walker.cell] < WALL)


@kernel
def fill_way(
    cells: Records, way: Field, queue: npt.NDArray[np.int32], goal: int, stride: int
) -> None:
    """Fill `way` with the human's steps to the cell `goal` over the shared floor."""
    for n in range(way.size):
        way[n] = UNREACHED if cells[n].kind == SHARED else WALL
    fill_marked(stride, np.array([goal], dtype=np.int32), way, queue, -1)


@kernel
def turn_to_aim(trial: Record, cosines: Floats, walker: Record) -> None:
    """Look at the aim; stand still when it is reached."""
    dx = walker.aim_x - trial.x
    dy = walker.aim_y - trial.y
    if dx * dx + dy * dy < 0.0025:
        walker.keys = 0
    else:
        walker.yaw = face(dx, dy, cosines)


@kernel
def walk(
    trial: Record, cells: Records, robots: Records, fields: npt.NDArray[np.int16],
    way: Field, around: Field, queue: npt.NDArray[np.int32], walker: Record, stride: int,
    cosines: Floats,
) -> None:  # fmt: skip
    """Set the walker's keys and yaw for this tick so that it gets nearer to its goal.

    It is given parts and not the whole state: handing all arrays over at each tick costs 5 %.
    """
    walker.keys = 0
    if walker.goal == NOWHERE:
        walker.still = 0
        return
    walker.cell = cell_of(cells, trial.x, trial.y, stride)
    walker.still += 1
    if walker.still >= STUCK_TICKS:
        dx = trial.x - walker.x
        dy = trial.y - walker.y
        if dx * dx + dy * dy < STUCK_M * STUCK_M and walker.around == 0:
            field = way if walker.goal == OWN_WAY else fields[walker.goal]
            if look_around(cells, robots, field, around, queue, walker, stride):
                walker.around = AROUND_TICKS
        walker.still = 0
        walker.x = trial.x
        walker.y = trial.y
    if walker.around > 0:
        walker.around -= 1
        aim(cells, around, walker, walker.cell, stride)
    elif walker.goal == OWN_WAY:
        aim(cells, way, walker, walker.cell, stride)
    else:
        aim(cells, fields[walker.goal], walker, walker.cell, stride)
    walker.keys = 1
    turn_to_aim(trial, cosines, walker)


@kernel
def note_frame(
    walker: Record, tick: int, frames: npt.NDArray[np.int32], record: npt.NDArray[np.int32]
) -> None:
    """Put the walker's keys and yaw into `frames`, int32[1, 2], for the coming step.

    `record`: int32[most ticks, 2] takes those of each tick; int32[0, 2] takes none.
    """
    frames[0, 0] = walker.keys
    frames[0, 1] = walker.yaw
    if tick < record.shape[0]:
        record[tick, 0] = walker.keys
        record[tick, 1] = walker.yaw


class Legs:
    """What any simulated worker walks with. `ways`: int16[2, C], its way and one round robots."""

    def __init__(self, motion: Motion) -> None:
        self.walkers = np.zeros(1, dtype=WALKER)
        self.ways = np.zeros((2, motion.cells.size), dtype=np.int16)

    @property
    def frame(self) -> tuple[int, int]:
        """Keys and yaw for the coming tick."""
        return int(self.walkers["keys"][0]), int(self.walkers["yaw"][0])


def seed_draws(seed: int) -> npt.NDArray[np.uint64]:
    """Return a stream of random numbers for compiled code, uint64[1]."""
    return np.array([(seed * 2 + 1) & (2**64 - 1)], dtype=np.uint64)
