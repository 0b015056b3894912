"""Shortest paths on the padded lattice: distance fields, straight-loving descents, cut cells.

The padded lattice has PAD border columns and rows on every side of the shared grid, so that every
neighbour of a shared cell, bay or home exists: cell (i, j) has index (j + PAD) * stride + (i + PAD)
with stride W + 2 PAD. `kinds[index]` is SOLID, SHARED, BAY or HOME.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from study.warehouse.kernels import kernel

PAD = 2
SOLID = 0
SHARED = 1
BAY = 2
HOME = 3
UNREACHED = 32000
WALL = UNREACHED - 1

Cells = npt.NDArray[np.int32]
Kinds = npt.NDArray[np.uint8]
Field = npt.NDArray[np.int16]


@kernel
def fill_field(kinds: Kinds, stride: int, goals: Cells, field: Field, queue: Cells) -> None:
    """Fill `field` with the steps to the nearest of `goals`: UNREACHED where none, WALL in solids.

    Every non-solid cell is open. `queue`: scratch of at least as many cells as the lattice has.
    """
    for n in range(field.size):
        field[n] = WALL if kinds[n] == SOLID else UNREACHED
    fill_marked(stride, goals, field, queue, -1)


@kernel
def fill_marked(stride: int, goals: Cells, field: Field, queue: Cells, enough: int) -> None:
    """Fill those cells of `field` that hold UNREACHED with their steps to the nearest goal.

    Cells that hold WALL are closed. Stops early once the cell `enough` is reached (-1: fills all).
    """
    tail = 0
    for m in range(goals.size):
        if goals[m] >= 0 and field[goals[m]] == UNREACHED:
            field[goals[m]] = 0
            queue[tail] = goals[m]
            tail += 1
    head = 0
    while head < tail:
        cell = queue[head]
        head += 1
        further = field[cell] + 1
        for d in range(4):
            other = cell + neighbour_offset(d, stride)
            if field[other] == UNREACHED:
                field[other] = further
                queue[tail] = other
                tail += 1
                if other == enough:
                    return


@kernel
def neighbour_offset(direction: int, stride: int) -> int:
    """Return the index difference to the neighbour: 0 right, 1 up, 2 left, 3 down."""
    if direction == 0:
        return 1
    if direction == 1:
        return stride
    if direction == 2:
        return -1
    return -stride


@kernel
def descend(field: Field, stride: int, start: int, heading: int, path: Cells) -> int:
    """Write the cells from `start` down to the goal into `path`; return how many.

    Turns as late as it can: `heading` (0..3, or -1) is the direction it comes with. Returns 0 if
    the goal is not reachable; a path longer than `path` is cut off at its far end.
    """
    if field[start] >= WALL:
        return 0
    cell = start
    count = 1
    path[0] = cell
    while field[cell] > 0 and count < path.size:
        step = -1
        if heading >= 0 and field[cell + neighbour_offset(heading, stride)] == field[cell] - 1:
            step = heading
        else:
            for d in range(4):
                if field[cell + neighbour_offset(d, stride)] == field[cell] - 1:
                    step = d
                    break
        heading = step
        cell += neighbour_offset(step, stride)
        path[count] = cell
        count += 1
    return count


def find_cut_cells(open_cells: npt.NDArray[np.bool_]) -> tuple[int, list[tuple[int, int]]]:
    """Return how many connected parts the grid has, and the cells whose loss would cut one.

    `open_cells`: bool[H, W] indexed [j, i]; 4 neighbours. Returned cells are (i, j). Iterative form
    of Hopcroft and Tarjan's depth-first search.
    """
    height, width = open_cells.shape
    depth = np.zeros((height, width), dtype=np.int64)
    low = np.zeros((height, width), dtype=np.int64)
    cuts: set[tuple[int, int]] = set()
    parts = 0
    for j0, i0 in np.argwhere(open_cells).tolist():
        if depth[j0, i0]:
            continue
        parts += 1
        _search_part(open_cells, (i0, j0), depth, low, cuts)
    return parts, sorted(cuts)


def _search_part(
    open_cells: npt.NDArray[np.bool_],
    root: tuple[int, int],
    depth: npt.NDArray[np.int64],
    low: npt.NDArray[np.int64],
    cuts: set[tuple[int, int]],
) -> None:
    """Walk one connected part depth first and add its cut cells to `cuts`."""
    height, width = open_cells.shape
    depth[root[1], root[0]] = low[root[1], root[0]] = 1
    root_branches = 0
    trail = [(root, root, 0)]
    while trail:
        (i, j), parent, tried = trail.pop()
        if tried < 4:
            trail.append(((i, j), parent, tried + 1))
            a = i + (1, 0, -1, 0)[tried]
            b = j + (0, 1, 0, -1)[tried]
            if not (0 <= a < width and 0 <= b < height and open_cells[b, a]) or (a, b) == parent:
                continue
            if depth[b, a]:
                low[j, i] = min(low[j, i], depth[b, a])
            else:
                depth[b, a] = low[b, a] = depth[j, i] + 1
                root_branches += (i, j) == root
                trail.append(((a, b), (i, j), 0))
        elif (i, j) != root:
            p, q = parent
            low[q, p] = min(low[q, p], low[j, i])
            if parent != root and low[j, i] >= depth[q, p]:
                cuts.add(parent)
    if root_branches > 1:
        cuts.add(root)
