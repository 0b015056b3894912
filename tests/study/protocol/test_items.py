"""Guards the kinds of items: which answers each takes, and in which order a person meets them."""

from __future__ import annotations

from collections import Counter

import pytest
from hypothesis import given
from hypothesis import strategies as st

from study.errors import AnswerError
from study.protocol.answers import validate_answers
from study.protocol.items import (
    Item,
    NumberItem,
    RatingItem,
    SliderItem,
    answer_label,
    levels_of,
    unit_of,
)
from study.protocol.questionnaires import Instrument

TLX = Instrument(use="nasa-tlx", random_order=True)
RATING = RatingItem(name="r", label="?", lowest=-10, highest=10, step=5, low="worse", high="better")
SLIDER = SliderItem(name="s", label="?", step=10, low="none", high="all", unit="%")


def stored(item: Item, raw: str) -> str | None:
    """What is stored of an answer, or None if it is refused."""
    try:
        return validate_answers([item], {item.name: raw})[item.name]
    except AnswerError:
        return None


@given(st.integers(-30, 30))
def test_a_rating_takes_its_points_only(figure: int) -> None:
    fits = figure in (-10, -5, 0, 5, 10)
    assert stored(RATING, str(figure)) == (str(figure) if fits else None)


@pytest.mark.parametrize(
    "raw", ["", "55", "-10", "101", "1e1", "5.0", "٣", "ten", "--10", "9" * 400]
)
def test_a_slider_takes_its_steps_only(raw: str) -> None:
    assert stored(SLIDER, raw) is None
    assert stored(SLIDER, " 50 ") == "50"


def test_a_slider_that_may_be_left_is_stored_empty() -> None:
    assert stored(SLIDER.model_copy(update={"required": False}), "") == ""


def test_numbers_may_be_below_zero() -> None:
    item = NumberItem(name="n", label="?", lowest=-5, highest=5)
    assert [stored(item, raw) for raw in ("-5", "-6", "05", "-0")] == ["-5", None, "5", "0"]


def test_what_codebooks_say_of_stepped_items() -> None:
    assert levels_of(RATING) == (("-10", "worse"), ("10", "better"))
    assert (unit_of(SLIDER), unit_of(RATING)) == ("%", "")
    assert answer_label(SLIDER, "50") == "50"


def test_the_tlx_has_21_points_from_0_to_100() -> None:
    for item in TLX.items:
        assert isinstance(item, RatingItem)
        assert (len(item.points), item.points[0], item.points[-1]) == (21, 0, 100)
    ends = {item.name: levels_of(item)[0][1] for item in TLX.items}
    assert ends["performance"] == "Perfect"


def test_a_random_order_is_the_persons_own_and_comes_from_the_seed() -> None:
    first = [item.name for item in TLX.arranged(1, "P-A").items]
    assert first == [item.name for item in TLX.arranged(1, "P-A").items]
    assert first != [item.name for item in TLX.arranged(2, "P-A").items]
    assert sorted(first) == sorted(item.name for item in TLX.items)
    plain = TLX.model_copy(update={"random_order": False})
    assert plain.arranged(1, "P-A") is plain


def test_every_item_comes_first_about_equally_often() -> None:
    firsts = Counter(TLX.arranged(7, f"P-{k}").items[0].name for k in range(1200))
    assert len(firsts) == 6
    assert all(abs(count - 200) < 60 for count in firsts.values())
