"""The generator: the five presets as tabled, honest errors, and paths that are really shortest."""

from __future__ import annotations

from collections import deque
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings

from study.errors import LayoutError
from study.warehouse.layout import PRESETS, HallSpec, Layout, build_layout
from study.warehouse.routes import find_cut_cells
from tests.strategies import hall_specs

TABLE = {
    # shelves, robots, boxes each, W, H, hall m, x0, y0, bays, cap s, speed
    "practice": (6, 1, 1, 21, 13, (13.2, 9.0), 4, 4, 1, 180, 1.0),
    "small": (18, 6, 3, 21, 34, (13.2, 21.6), 4, 4, 3, 900, 1.0),
    "study": (48, 12, 3, 46, 34, (28.2, 21.6), 4, 4, 6, 1500, 1.0),
    "large": (225, 15, 3, 81, 85, (49.2, 52.2), 4, 4, 8, 3600, 1.0),
    "lab": (4, 3, 3, 24, 23, (15.0, 15.0), 8, 9, 2, 1500, 0.5),
}


@pytest.mark.parametrize("name", TABLE)
def test_presets_are_as_tabled(name: str) -> None:
    """Guards every published figure of the five halls."""
    layout = build_layout(PRESETS[name])
    spec = layout.spec
    shelves, robots, boxes, width, height, hall_m, x0, y0, bays, cap_s, speed = TABLE[name]
    assert len(layout.shelf_cells) == len(layout.shelves_m) == shelves
    assert (spec.robots, spec.boxes_per_robot) == (robots, boxes)
    assert (layout.width_cells, layout.height_cells) == (width, height)
    assert (layout.hall_width_m, layout.hall_height_m) == pytest.approx(hall_m)
    assert tuple(layout.shelf_cells[0]) == (x0, y0)
    assert [len(station.bay_cells) for station in layout.stations] == [bays] * 4
    assert (spec.cap_s, spec.robot_speed_mps, spec.human_speed_mps) == (cap_s, speed, 1.4)
    first = (height - (2 * robots - 1)) // 2
    assert layout.homes.tolist() == [[width, first + 2 * k] for k in range(robots)]


def test_shelves_stand_where_the_formula_puts_them() -> None:
    """Guards the pitches: 5 cells between columns, 4 between rows, 5 more after each third row."""
    layout = build_layout(PRESETS["study"])
    expected = [(4 + 5 * c, 4 + 4 * r + 5 * (r // 3)) for r in range(6) for c in range(8)]
    assert [tuple(cell) for cell in layout.shelf_cells.tolist()] == expected
    assert layout.shelves_m[0] == pytest.approx([2.4, 3.0, 4.2, 3.6])


def test_stations_lie_in_their_corners() -> None:
    """Guards bays, mouths and the order bottom left, bottom right, top right, top left."""
    stations = build_layout(PRESETS["study"]).stations
    assert stations[0].bay_cells == tuple((i, -1) for i in (1, 3, 5, 7, 9, 11))
    assert stations[1].bay_cells == tuple((i, -1) for i in (44, 42, 40, 38, 36, 34))
    assert stations[2].bay_cells[0] == (44, 34)
    assert stations[3].mouths[0] == (1, 33)
    assert stations[0].middle_mouth == (7, 0)
    assert stations[2].center_m == pytest.approx((0.3 + 0.6 * 39, 21.3))


@pytest.mark.parametrize("name", TABLE)
def test_human_starts_near_the_centre_with_room(name: str) -> None:
    """Guards the start: all 8 neighbours free, and no free cell with room lies nearer."""
    layout = build_layout(PRESETS[name])
    x, y = layout.human_start_m
    i, j = round((x - 0.3) / 0.6), round((y - 0.9) / 0.6)
    assert layout.free[j - 1 : j + 2, i - 1 : i + 2].all()
    middle = ((layout.width_cells - 1) / 2, (layout.height_cells - 1) / 2)
    here = (i - middle[0]) ** 2 + (j - middle[1]) ** 2
    for b in range(1, layout.height_cells - 1):
        for a in range(1, layout.width_cells - 1):
            if layout.free[b - 1 : b + 2, a - 1 : a + 2].all():
                assert (a - middle[0]) ** 2 + (b - middle[1]) ** 2 >= here


@pytest.mark.parametrize(
    ("change", "parameter"),
    [
        ({"shelf_columns": 0}, "hall.shelf_columns"),
        ({"robots": 2.5}, "hall.robots"),
        ({"robots": True}, "hall.robots"),
        ({"robots": 30}, "hall.robots"),
        ({"boxes_per_robot": 60}, "hall.boxes_per_robot"),
        ({"width_cells": 40}, "hall.width_cells"),
        ({"height_cells": 30}, "hall.height_cells"),
        ({"robot_speed_mps": float("nan")}, "hall.robot_speed_mps"),
        ({"cap_s": 1}, "hall.cap_s"),
        ({"stations": 5}, "hall.stations"),
        ({"unload_rule": "anywhere"}, "hall.unload_rule"),
        ({"robots": 17, "shelf_columns": 1, "width_cells": 20}, "hall.width_cells"),
        ({"nonsense": 1}, "hall.nonsense"),
    ],
)
def test_errors_name_the_parameter(change: dict[str, Any], parameter: str) -> None:
    """Guards that a hall which cannot be built says which parameter to change, and to what."""
    record = PRESETS["study"].to_json() | change
    with pytest.raises(LayoutError) as caught:
        build_layout(HallSpec.from_json(record))
    assert caught.value.where == parameter
    assert caught.value.next_step.startswith("Use ")


def test_missing_parameter_is_named() -> None:
    """Guards against a TypeError where a record lacks a key."""
    record = PRESETS["study"].to_json()
    del record["robots"]
    with pytest.raises(LayoutError, match=r"hall\.robots"):
        HallSpec.from_json(record)


def test_spec_survives_json() -> None:
    """Guards that a stored configuration rebuilds the same hall."""
    for spec in PRESETS.values():
        assert HallSpec.from_json(spec.to_json()) == spec


def reference_field(layout: Layout, goal: tuple[int, int]) -> np.ndarray[Any, Any]:
    """Breadth first search in plain Python."""
    field = np.full(layout.free.shape, -1)
    field[goal[1], goal[0]] = 0
    todo = deque([goal])
    while todo:
        i, j = todo.popleft()
        for a, b in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)):
            inside = 0 <= a < layout.width_cells and 0 <= b < layout.height_cells
            if inside and layout.free[b, a] and field[b, a] < 0:
                field[b, a] = field[j, i] + 1
                todo.append((a, b))
    return field


def test_distance_fields_are_shortest() -> None:
    """Guards the compiled search against a plain one, and bays being no thoroughfare."""
    for name in ("practice", "study"):
        layout = build_layout(PRESETS[name])
        for goal in [layout.stations[0].middle_mouth, (0, 5)]:
            assert (layout.distance_field(goal) == reference_field(layout, goal)).all()


def test_distance_field_refuses_other_cells() -> None:
    """Guards against silently reading outside of the grid."""
    with pytest.raises(LayoutError):
        build_layout(PRESETS["practice"]).distance_field((21, 3))


@settings(max_examples=20, deadline=None)
@given(hall_specs())
def test_no_single_cell_holds_a_hall_together(spec: HallSpec) -> None:
    """Guards the graph property that the right of way needs; checked by removing each cell."""
    layout = Layout(spec)
    parts, cuts = find_cut_cells(layout.free)
    assert (parts, cuts) == (1, [])
    for j, i in np.argwhere(layout.free)[::17].tolist():
        without = layout.free.copy()
        without[j, i] = False
        assert find_cut_cells(without)[0] == 1


def test_cut_cells_are_found() -> None:
    """Guards the check itself: a corridor of one cell is a cut, two halves are two parts."""
    grid = np.ones((3, 7), dtype=np.bool_)
    grid[0, 3] = grid[2, 3] = False
    assert find_cut_cells(grid) == (1, [(2, 1), (3, 1), (4, 1)])
    grid[1, 3] = False
    assert find_cut_cells(grid)[0] == 2
