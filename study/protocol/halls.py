"""A hall of the study's own, beside the five that come with the software."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from study.errors import LayoutError
from study.protocol.records import Problem, Record, refuse
from study.warehouse.halls import PRESETS, HallSpec

_AROUND = ("name", "shelf_columns", "shelf_rows", "margin_cells")


class Hall(Record):
    """Parameters of a hall; what is left out is as in the hall of the study.

    Without `width_cells` and `height_cells` the shelves get `margin_cells` of free floor all round.
    """

    name: Annotated[str, Field(pattern=r"^[a-z][a-z0-9-]{0,39}$")]
    shelf_columns: int
    shelf_rows: int
    robots: int
    boxes_per_robot: int
    margin_cells: int = 4
    width_cells: int | None = None
    height_cells: int | None = None
    x0_cells: int | None = None
    y0_cells: int | None = None
    stations: int = 4
    robot_speed_mps: float = 1.0
    human_speed_mps: float = 1.4
    cap_s: float = 1500.0
    unload_rule: Literal["near_robot", "near_station"] = "near_robot"
    unload_radius_m: float = 1.0
    unload_square_m: float = 2.5
    pick_s: float = 2.0
    unload_s: float = 0.5

    @model_validator(mode="after")
    def _check_parameters(self) -> Hall:
        if self.name in PRESETS:
            refuse([Problem(("name",), self.name, "a hall of the software has this name already")])
        try:
            _ = self.spec
        except LayoutError as error:
            refuse([problem_of(error, self)])
        return self

    @property
    def spec(self) -> HallSpec:
        """The hall as the simulation takes it. Errors: LayoutError naming the parameter."""
        given = {k: v for k, v in self.model_dump().items() if v is not None}
        name, columns, rows, margin = (given.pop(key) for key in _AROUND)
        around = HallSpec.around(name, columns, rows, margin, robots=1, boxes_per_robot=1)
        return HallSpec(**(around.to_json() | given))


def problem_of(error: LayoutError, hall: Hall) -> Problem:
    """A layout error as a problem at the hall's key."""
    key = error.where.removeprefix("hall.")
    key = key if key in Hall.model_fields else "name"
    return Problem((key,), getattr(hall, key), f"{error.what}. {error.next_step}".strip())
