"""Build a hall from its parameters: shelves, stations with bays, homes, and what is free.

Metres, origin in the hall's lower left corner, x right, y up. The centre of cell (i, j) is
(0.3 + 0.6 i, 0.9 + 0.6 j). The shared grid has W x H cells; below it (j = -1) and above it (j = H)
lie the stations' bays, right of it (i = W) the robots' homes: dead ends of one robot each, closed
to the human. Fixed by the paper: shelf counts and robots of the presets. Read off the authors'
simulator: pitches (snapped to the lattice), stations in the corners. Our choice: the rest.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from study.errors import LayoutError
from study.warehouse.halls import (
    BOXES_PER_SHELF,
    CELL_M,
    COLUMN_PITCH_CELLS,
    HUMAN_RADIUS_M,
    PRESETS,
    SHELF_CELLS,
    HallSpec,
    refuse,
    shelf_row_cell,
)
from study.warehouse.routes import (
    BAY,
    HOME,
    PAD,
    SHARED,
    SOLID,
    WALL,
    fill_field,
    find_cut_cells,
)

__all__ = ["PRESETS", "HallSpec", "Layout", "Station", "build_layout"]

Cell = tuple[int, int]
WALL_M = 1.0
NEAR_M = HUMAN_RADIUS_M + 0.1
"""The human's body and more than one frame's step: solids further from its cell do not matter."""


@dataclass(frozen=True)
class Station:
    """One drop station. `mouths[n]` is the shared cell in front of `bay_cells[n]`."""

    index: int
    bay_cells: tuple[Cell, ...]
    mouths: tuple[Cell, ...]
    middle_mouth: Cell
    center_m: tuple[float, float]


class Layout:
    """A hall that was checked: every robot can reach every shelf, bay and home by two ways.

    Arrays are read-only. `free`: bool[H, W] indexed [j, i]; `shelf_cells`: int[n, 2] lower left
    cell of shelf n = row * columns + column; `shelves_m`, `solids_m`: float64[n, 4] (x0, y0, x1,
    y1); `homes`: int[N, 2]; `kinds`: uint8 over the padded lattice. Make one with `build_layout`.
    """

    def __init__(self, spec: HallSpec) -> None:
        self.spec = spec
        self.width_cells = spec.width_cells
        self.height_cells = spec.height_cells
        self.stride = spec.width_cells + 2 * PAD
        self.hall_width_m = CELL_M * (spec.width_cells + 1)
        self.hall_height_m = CELL_M * (spec.height_cells + 2)
        self.shelf_cells = _place_shelves(spec)
        self.free = _free_cells(spec, self.shelf_cells)
        self.homes = _place_homes(spec)
        self.stations = _place_stations(spec)
        _check_mouths(self)
        _check_connected(self.free)
        self.shelves_m = _shelf_rectangles(self.shelf_cells)
        self.solids_m = _solid_rectangles(self)
        self.kinds = _cell_kinds(self)
        self.human_start_m = self.cell_center_m(*_start_cell(self.free))
        for array in (self.shelf_cells, self.free, self.homes, self.shelves_m, self.solids_m):
            array.setflags(write=False)
        self.kinds.setflags(write=False)
        self.distance_field = functools.lru_cache(maxsize=512)(self._distance_field)

    @staticmethod
    def cell_center_m(i: int, j: int) -> tuple[float, float]:
        """Return the centre of cell (i, j) in metres."""
        return 0.3 + CELL_M * i, 0.9 + CELL_M * j

    def cell_index(self, i: int, j: int) -> int:
        """Return the padded lattice's index of cell (i, j)."""
        return (j + PAD) * self.stride + i + PAD

    def index_cell(self, index: int) -> Cell:
        """Return the cell (i, j) of a padded lattice's index."""
        row, column = divmod(index, self.stride)
        return column - PAD, row - PAD

    def _distance_field(self, cell: Cell) -> npt.NDArray[np.int32]:
        """Return steps to `cell` over the shared grid: int32[H, W], -1 unreachable; read-only."""
        kinds = np.where(self.kinds == SHARED, self.kinds, SOLID).astype(np.uint8)
        field = np.empty(kinds.size, dtype=np.int16)
        queue = np.empty(kinds.size, dtype=np.int32)
        goal = np.array([self.cell_index(*cell)], dtype=np.int32)
        if not (0 <= cell[0] < self.width_cells and 0 <= cell[1] < self.height_cells):
            raise LayoutError(f"{cell} is no cell of the shared grid", where=self.spec.name)
        fill_field(kinds, self.stride, goal, field, queue)
        shape = (self.height_cells + 2 * PAD, self.stride)
        inner = field.reshape(shape)[PAD:-PAD, PAD:-PAD].astype(np.int32)
        inner[inner >= WALL] = -1
        inner.setflags(write=False)
        return inner


@functools.cache
def build_layout(spec: HallSpec) -> Layout:
    """Build and check the hall of `spec`; the same spec gives the same object.

    Errors: LayoutError naming the parameter that does not fit and what would.
    """
    return Layout(spec)


def _place_shelves(spec: HallSpec) -> npt.NDArray[np.int64]:
    cells = [
        (spec.x0_cells + COLUMN_PITCH_CELLS * c, shelf_row_cell(r, spec.y0_cells))
        for r in range(spec.shelf_rows)
        for c in range(spec.shelf_columns)
    ]
    right = cells[-1][0] + SHELF_CELLS
    top = cells[-1][1] + 1
    if right + 2 > spec.width_cells:
        raise refuse(
            "width_cells",
            f"the shelves end at column {right} of {spec.width_cells}, with no aisle beside them",
            f"at least {right + 2}, fewer shelf_columns or a smaller x0_cells",
        )
    if top + 2 > spec.height_cells:
        raise refuse(
            "height_cells",
            f"the shelves end at row {top} of {spec.height_cells}, without an aisle above them",
            f"at least {top + 2}, fewer shelf_rows or a smaller y0_cells",
        )
    return np.array(cells, dtype=np.int64)


def _free_cells(spec: HallSpec, shelf_cells: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
    free = np.ones((spec.height_cells, spec.width_cells), dtype=np.bool_)
    for i, j in shelf_cells.tolist():
        free[j, i : i + SHELF_CELLS] = False
    return free


def _place_homes(spec: HallSpec) -> npt.NDArray[np.int64]:
    needed = 2 * spec.robots - 1
    if needed > spec.height_cells:
        raise refuse(
            "robots",
            f"the homes of {spec.robots} robots need {needed} rows, the hall has "
            f"{spec.height_cells}",
            f"at most {(spec.height_cells + 1) // 2} robots or a larger height_cells",
        )
    first = (spec.height_cells - needed) // 2
    return np.array([(spec.width_cells, first + 2 * k) for k in range(spec.robots)])


def _place_stations(spec: HallSpec) -> tuple[Station, ...]:
    bays = spec.bays_per_station
    both_sides = spec.stations > 1
    needed = 4 * bays + 1 if both_sides else 2 * bays + 1
    if needed > spec.width_cells:
        raise refuse(
            "width_cells",
            f"{bays} bays per station need {needed} columns, the hall has {spec.width_cells}",
            f"at least {needed}, or fewer robots",
        )
    stations = []
    for index in range(spec.stations):
        left = index in (0, 3)
        bottom = index in (0, 1)
        columns = [1 + 2 * n if left else spec.width_cells - 2 - 2 * n for n in range(bays)]
        row, mouth = (-1, 0) if bottom else (spec.height_cells, spec.height_cells - 1)
        x_m = sum(0.3 + CELL_M * i for i in columns) / bays
        stations.append(
            Station(
                index=index,
                bay_cells=tuple((i, row) for i in columns),
                mouths=tuple((i, mouth) for i in columns),
                middle_mouth=(columns[bays // 2], mouth),
                center_m=(x_m, 0.9 + CELL_M * row),
            )
        )
    return tuple(stations)


def _check_mouths(layout: Layout) -> None:
    for station in layout.stations:
        for i, j in station.mouths:
            if not layout.free[j, i]:
                raise refuse("y0_cells", f"a shelf covers the bay mouth {(i, j)}", "a larger value")
    for i, j in layout.homes.tolist():
        if not layout.free[j, i - 1]:
            raise refuse(
                "width_cells", f"a shelf covers the home mouth {(i - 1, j)}", "a larger value"
            )


def _check_connected(free: npt.NDArray[np.bool_]) -> None:
    parts, cuts = find_cut_cells(free)
    if parts != 1:
        raise refuse(
            "x0_cells",
            f"the free floor falls into {parts} parts",
            "wider margins around the shelves",
        )
    if cuts:
        raise refuse(
            "x0_cells",
            f"the free floor hangs together at cell {cuts[0]} alone, where robots could deadlock",
            "margins of at least 2 cells around the shelves",
        )


def _shelf_rectangles(shelf_cells: npt.NDArray[np.int64]) -> npt.NDArray[np.float64]:
    rectangles = [
        (CELL_M * i, 0.6 + CELL_M * j, CELL_M * (i + SHELF_CELLS), 0.6 + CELL_M * (j + 1))
        for i, j in shelf_cells.tolist()
    ]
    return np.array(rectangles, dtype=np.float64)


def _solid_rectangles(layout: Layout) -> npt.NDArray[np.float64]:
    right = CELL_M * layout.width_cells
    top = 0.6 + CELL_M * layout.height_cells
    far_x = layout.hall_width_m + WALL_M
    far_y = layout.hall_height_m + WALL_M
    walls = [
        (-WALL_M, -WALL_M, far_x, 0.6),
        (-WALL_M, top, far_x, far_y),
        (-WALL_M, -WALL_M, 0.0, far_y),
        (right, -WALL_M, far_x, far_y),
    ]
    return np.vstack([np.array(walls, dtype=np.float64), layout.shelves_m])


def _cell_kinds(layout: Layout) -> npt.NDArray[np.uint8]:
    kinds = np.full((layout.height_cells + 2 * PAD, layout.stride), SOLID, dtype=np.uint8)
    kinds[PAD:-PAD, PAD:-PAD] = np.where(layout.free, SHARED, SOLID)
    for station in layout.stations:
        for i, j in station.bay_cells:
            kinds[j + PAD, i + PAD] = BAY
    for i, j in layout.homes.tolist():
        kinds[j + PAD, i + PAD] = HOME
    return kinds.reshape(-1)


def _start_cell(free: npt.NDArray[np.bool_]) -> Cell:
    """Return the free cell nearest the centre with 8 free neighbours; ties: lowest j, then i."""
    height, width = free.shape
    best: tuple[int, int, int] | None = None
    for j in range(1, height - 1):
        for i in range(1, width - 1):
            if free[j - 1 : j + 2, i - 1 : i + 2].all():
                rank = ((2 * i - width + 1) ** 2 + (2 * j - height + 1) ** 2, j, i)
                best = rank if best is None or rank < best else best
    if best is None:
        raise refuse("height_cells", "the human finds no room to stand", "a larger value")
    return best[2], best[1]


def solids_near_cells(layout: Layout) -> npt.NDArray[np.int16]:
    """Return, for each padded cell, the solids near enough to stop a human whose centre is in it.

    int16[cells, m], ascending indices into `solids_m`, filled up with -1.
    """
    rows = layout.height_cells + 2 * PAD
    i, j = np.meshgrid(np.arange(layout.stride) - PAD, np.arange(rows) - PAD)
    x, y = (CELL_M * i).reshape(-1, 1), (0.6 + CELL_M * j).reshape(-1, 1)
    x0, y0, x1, y1 = layout.solids_m.T
    near = (x0 < x + CELL_M + NEAR_M) & (x1 > x - NEAR_M)
    near &= (y0 < y + CELL_M + NEAR_M) & (y1 > y - NEAR_M)
    found = [np.flatnonzero(row) for row in near]
    table = np.full((len(found), max(map(len, found)) + 1), -1, dtype=np.int16)
    for row, indices in zip(table, found, strict=True):
        row[: len(indices)] = indices
    return table


def boxes_in_stock(layout: Layout) -> int:
    """Return how many boxes the shelves hold: 12 on each."""
    return len(layout.shelf_cells) * BOXES_PER_SHELF
