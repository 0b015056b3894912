"""Lattice path lengths from the human, as the agents know them."""

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
"""The shared grid starts this far above the hall's lower edge."""
