"""Guards the library of instruments: each is complete, and says where it comes from."""

from __future__ import annotations

import pytest

from study.protocol.instruments.library import NAMES
from study.protocol.items import ChoiceItem, RatingItem, ScaleItem, levels_of
from study.protocol.questionnaires import Instrument
from study.protocol.scoring import scores_of, scoring_problem

MEASURING = ("demographics", "paper-q1-q6", "nasa-tlx", "sus")


@pytest.mark.parametrize("name", NAMES)
def test_every_item_has_a_wording_and_anchors(name: str) -> None:
    """What is rated has both ends labelled; what is chosen has a label for every option."""
    instrument = Instrument(use=name)
    assert instrument.items
    assert instrument.title
    for item in instrument.items:
        assert len(item.label) > 3
        if isinstance(item, RatingItem):
            assert all(label for _, label in levels_of(item)), item.name
        if isinstance(item, ScaleItem | ChoiceItem):
            assert len(item.options) >= 2
            assert all(option.label for option in item.options), item.name


@pytest.mark.parametrize("name", MEASURING)
def test_what_measures_names_its_source_and_can_be_scored_as_it_says(name: str) -> None:
    instrument = Instrument(use=name)
    assert len(instrument.source) > 40
    assert scoring_problem(instrument) == ""
    assert bool(scores_of(instrument)) == (name in ("nasa-tlx", "sus"))


def test_the_ends_of_the_published_scales() -> None:
    """TLX from low to high but for performance; SUS from no to yes, its even items turned round."""
    for item in Instrument(use="nasa-tlx").items:
        ends = ("Perfect", "Failure") if item.name == "performance" else ("Very low", "Very high")
        assert tuple(label for _, label in levels_of(item)) == ends
    sus = [item for item in Instrument(use="sus").items if isinstance(item, RatingItem)]
    assert [item.reverse for item in sus] == [False, True] * 5
    for rating in sus:
        assert levels_of(rating) == (("1", "Strongly disagree"), ("5", "Strongly agree"))


@pytest.mark.parametrize("name", ["paper-q1-q6", "nasa-tlx", "sus"])
def test_any_of_them_may_be_asked_in_random_order(name: str) -> None:
    """The same items, arranged for one participant; the score does not depend on the order."""
    instrument = Instrument(use=name, random_order=True)
    arranged = instrument.arranged(3, "P-ABCDEFGH")
    assert {item.name for item in arranged.items} == {item.name for item in instrument.items}
    assert scores_of(arranged) == scores_of(instrument)
