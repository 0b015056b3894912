"""The parameters of a hall and its world, and the five presets.

Fixed by the paper: three scales by their shelf counts and robots (18 shelves; 12 robots and 36
boxes in the study; 225 shelves and 15 robots; 3 robots at 0.5 m/s in a 2500 square feet lab), the
1.0 m unload radius, and a one-robot practice hall. Read off the authors' public simulator: shelf
pitches, corner stations, 1.0 m/s robots. Our choice: everything else here, as named settings.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from types import MappingProxyType
from typing import Any, Literal, Self

from study.errors import LayoutError

CELL_M = 0.6
ROBOT_RADIUS_M = 0.2
HUMAN_RADIUS_M = 0.3
EYE_HEIGHT_M = 1.65
TICK_HZ = 30
BOXES_PER_SHELF = 12
COLOURS = 4
SHELF_CELLS = 3
COLUMN_PITCH_CELLS = 5
ROW_PITCH_CELLS = 4
SECTION_ROWS = 3
SECTION_GAP_CELLS = 5

_COUNTS = {
    "shelf_columns": (1, 40),
    "shelf_rows": (1, 40),
    "robots": (1, 100),
    "boxes_per_robot": (1, 100),
    "width_cells": (5, 210),
    "height_cells": (4, 210),
    "x0_cells": (1, 100),
    "y0_cells": (1, 100),
    "stations": (1, 4),
}
_AMOUNTS = {
    "robot_speed_mps": (0.1, 2.0),
    "human_speed_mps": (0.2, 3.0),
    "cap_s": (10.0, 36000.0),
    "pick_s": (0.1, 60.0),
    "unload_s": (0.1, 60.0),
    "unload_radius_m": (0.75, 5.0),
    "unload_square_m": (1.0, 10.0),
}


@dataclass(frozen=True)
class HallSpec:
    """Everything that defines a hall and its world; checked when made.

    Lengths in cells of 0.6 m where the name says `cells`. `x0_cells`, `y0_cells`: lower left cell
    of the first shelf. Errors: LayoutError naming the parameter.
    """

    name: str
    shelf_columns: int
    shelf_rows: int
    robots: int
    boxes_per_robot: int
    width_cells: int
    height_cells: int
    x0_cells: int = 4
    y0_cells: int = 4
    robot_speed_mps: float = 1.0
    cap_s: float = 1500.0
    stations: int = 4
    human_speed_mps: float = 1.4
    unload_rule: Literal["near_robot", "near_station"] = "near_robot"
    unload_radius_m: float = 1.0
    unload_square_m: float = 2.5
    pick_s: float = 2.0
    unload_s: float = 0.5

    def __post_init__(self) -> None:
        for parameter, (low, high) in (_COUNTS | _AMOUNTS).items():
            value = getattr(self, parameter)
            kind = int if parameter in _COUNTS else (int, float)
            if isinstance(value, bool) or not isinstance(value, kind):
                wanted = "a whole number" if parameter in _COUNTS else "a number"
                raise refuse(parameter, f"{value!r} is not {wanted}", f"between {low} and {high}")
            if not (math.isfinite(value) and low <= value <= high):
                raise refuse(parameter, f"{value} is out of range", f"between {low} and {high}")
        if self.unload_rule not in ("near_robot", "near_station"):
            raise refuse(
                "unload_rule", f"{self.unload_rule!r} is unknown", "near_robot or near_station"
            )
        stock = self.shelf_columns * self.shelf_rows * BOXES_PER_SHELF
        if self.robots * self.boxes_per_robot > stock:
            raise refuse(
                "boxes_per_robot",
                f"{self.robots} robots x {self.boxes_per_robot} boxes exceed the {stock} stored",
                f"at most {stock // self.robots}",
            )

    @property
    def boxes_total(self) -> int:
        """How many boxes a trial delivers."""
        return self.robots * self.boxes_per_robot

    @property
    def bays_per_station(self) -> int:
        """Bays that one station needs so that it can never be full.

        A robot goes to the emptier of two stations, so one of them never has more than half of the
        robots, rounded up. With a single station there is no second one to go to.
        """
        return self.robots if self.stations == 1 else (self.robots + 1) // 2

    def to_json(self) -> dict[str, Any]:
        """Return all parameters as plain JSON values."""
        return asdict(self)

    @classmethod
    def from_json(cls, record: Mapping[str, Any]) -> Self:
        """Rebuild a spec from `to_json`. Errors: LayoutError naming an unknown or missing key."""
        known = {field.name: field for field in fields(cls)}
        for key in record:
            if key not in known:
                raise refuse(str(key), "there is no such parameter", f"one of {', '.join(known)}")
        for key in list(known)[:7]:
            if key not in record:
                raise refuse(key, "it is missing", "a value for it")
        return cls(**record)

    @classmethod
    def around(
        cls, name: str, shelf_columns: int, shelf_rows: int, margin_cells: int = 4, **settings: Any
    ) -> Self:
        """Make a spec whose shared grid leaves `margin_cells` free on every side of the shelves."""
        width = COLUMN_PITCH_CELLS * (shelf_columns - 1) + SHELF_CELLS + 2 * margin_cells
        top_row = shelf_row_cell(shelf_rows - 1, margin_cells)
        return cls(
            name=name,
            shelf_columns=shelf_columns,
            shelf_rows=shelf_rows,
            width_cells=width,
            height_cells=top_row + 1 + margin_cells,
            x0_cells=margin_cells,
            y0_cells=margin_cells,
            **settings,
        )


def refuse(parameter: str, what: str, allowed: str) -> LayoutError:
    """Make the error that names a hall's parameter and what it allows."""
    return LayoutError(what, where=f"hall.{parameter}", next_step=f"Use {allowed}.")


def shelf_row_cell(row: int, y0_cells: int) -> int:
    """Return the j of a shelf row: pitch 4 cells, and 5 cells more after each third row."""
    return y0_cells + ROW_PITCH_CELLS * row + SECTION_GAP_CELLS * (row // SECTION_ROWS)


PRESETS: Mapping[str, HallSpec] = MappingProxyType(
    {
        spec.name: spec
        for spec in (
            HallSpec("practice", 3, 2, 1, 1, 21, 13, cap_s=180.0),
            HallSpec("small", 3, 6, 6, 3, 21, 34, cap_s=900.0),
            HallSpec("study", 8, 6, 12, 3, 46, 34, cap_s=1500.0),
            HallSpec("large", 15, 15, 15, 3, 81, 85, cap_s=3600.0),
            HallSpec("lab", 2, 2, 3, 3, 24, 23, 8, 9, robot_speed_mps=0.5, cap_s=1500.0),
        )
    }
)
"""practice: one robot; small: the paper's miniature; study: the paper's study; large; lab."""
