"""Guards Cohen's kappa against hand counts, and what is compared at all."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from study.learning.agreement import ELEMENTS, Agreement, Setting, kappa


def setting(agent: int, mask: int, lead_mask: int, drawn: int = 7, expert: str = "ben") -> Setting:
    return Setting(0, 120, expert, agent, mask, lead_mask, drawn)


def test_a_textbook_table() -> None:
    """50 grants, both yes 20, both no 15, 5 and 10 apart: kappa 0.4."""
    assert kappa(15, 10, 5, 20) == pytest.approx(0.4)


@pytest.mark.parametrize("table", [(0, 0, 0, 0), (9, 0, 0, 0), (0, 0, 0, 9)])
def test_it_is_not_defined_where_both_always_say_the_same(table: tuple[int, ...]) -> None:
    assert kappa(*table) is None


@given(st.tuples(*[st.integers(0, 400)] * 4))
def test_its_range_and_symmetry(table: tuple[int, int, int, int]) -> None:
    """At most 1, at least -1, the same whoever leads; 1 exactly when nothing differs."""
    neither, lead, mine, both = table
    value = kappa(neither, lead, mine, both)
    assert value == kappa(neither, mine, lead, both)
    if value is not None:
        assert -1 <= value <= 1
        assert (value == 1) == (lead == mine == 0)


def test_each_element_is_counted_where_it_could_draw() -> None:
    agreement = Agreement(robots=2)
    for entry in (
        setting(0, 0b001, 0b101),
        setting(1, 0b110, 0b000, drawn=0b001),
        setting(2, 1, 1, drawn=1),
        setting(3, 1, 0, drawn=0),
    ):
        agreement.add(entry)
    counted = {name: agreement.pairs("ben", name) for name in ELEMENTS}
    assert counted == {
        "live_location": 2, "transparent_avatar": 1, "trajectory": 1, "balloon": 1,
    }  # fmt: skip
    assert agreement.kappa("ben", "live_location") == 1.0
    assert agreement.kappa("ben", "trajectory") == 0.0
    assert agreement.kappa("ben", "balloon") is None


def test_experts_are_counted_apart() -> None:
    agreement = Agreement(robots=1)
    agreement.add(setting(0, 7, 0))
    agreement.add(setting(0, 0, 0, expert="cleo"))
    assert agreement.experts() == ("ben", "cleo")
    assert agreement.pairs("cleo", "trajectory") == 1
