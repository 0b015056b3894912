"""Lattice path lengths from the human, as the AR agents know them."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from study.ar.situation import ObservedWorld
    from study.warehouse.layout import Layout

CELL_M = 0.6
FLOOR_Y_M = 0.6
"""The shared grid starts so far above the hall's lower edge."""


def nearest_free_cell(layout: Layout, x_m: float, y_m: float) -> tuple[int, int]:
    """The free cell of the shared grid whose centre is nearest to a place (ties: lowest j, i)."""
    i = min(max(int(x_m // CELL_M), 0), layout.width_cells - 1)
    j = min(max(int((y_m - FLOOR_Y_M) // CELL_M), 0), layout.height_cells - 1)
    if layout.free[j, i]:
        return i, j
    rows, columns = np.nonzero(layout.free)
    x, y = layout.cell_center_m(0, 0)
    squares = (x + CELL_M * columns - x_m) ** 2 + (y + CELL_M * rows - y_m) ** 2
    nearest = int(np.argmin(squares))
    return int(columns[nearest]), int(rows[nearest])


def human_field(world: ObservedWorld) -> NDArray[np.int32]:
    """Steps from the human's nearest free cell to each cell: int32[H, W], -1 unreachable."""
    layout = world.layout
    cell = nearest_free_cell(layout, float(world.human_x_m), float(world.human_y_m))
    return layout.distance_field(cell)


@lru_cache(maxsize=32)
def station_mouths(layout: Layout) -> NDArray[np.int64]:
    """The middle mouth (i, j) of each station, int[stations, 2]."""
    return np.array([station.middle_mouth for station in layout.stations], np.int64)
