"""Hypothesis strategies for halls, inputs and worlds."""

from __future__ import annotations

from hypothesis import strategies as st

from study.warehouse.layout import HallSpec

Script = list[tuple[int, int, int]]


@st.composite
def hall_specs(draw: st.DrawFn) -> HallSpec:
    """Small halls of every shape that the generator accepts, with one to eight robots."""
    columns, rows, margin = (
        draw(st.integers(2, 4)),
        draw(st.integers(1, 4)),
        draw(st.integers(3, 5)),
    )
    empty = HallSpec.around("empty", columns, rows, margin, robots=1, boxes_per_robot=1)
    most = min((empty.height_cells + 1) // 2, 2 * ((empty.width_cells - 1) // 4), 8)
    return HallSpec.around(
        "drawn",
        columns,
        rows,
        margin,
        robots=draw(st.integers(1, most)),
        boxes_per_robot=draw(st.integers(1, 2)),
        stations=draw(st.sampled_from([2, 4])),
        robot_speed_mps=draw(st.sampled_from([0.5, 0.8, 1.0])),
        cap_s=600.0,
    )


def input_scripts(longest: int = 16) -> st.SearchStrategy[Script]:
    """Stretches of (ticks, keys, yaw): somebody who walks, stands and turns at will."""
    stretch = st.tuples(st.integers(1, 90), st.integers(0, 15), st.integers(0, 65535))
    return st.lists(stretch, min_size=1, max_size=longest)


def seeds() -> st.SearchStrategy[int]:
    """Seeds of trials."""
    return st.integers(0, 2**63 - 1)
