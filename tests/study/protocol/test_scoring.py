"""Guards the scores of instruments against their definitions."""

from __future__ import annotations

import pytest

from study.protocol.items import DECLINED
from study.protocol.questionnaires import Instrument
from study.protocol.scoring import Score, score, scores_of

TLX, SUS = Instrument(use="nasa-tlx"), Instrument(use="sus")
OWN = Instrument.model_validate(
    {
        "name": "own",
        "title": "Own",
        "scoring": "mean",
        "options": ["no", "perhaps", "yes"],
        "items": [
            {"kind": "scale", "name": "a", "label": "?"},
            {"kind": "scale", "name": "b", "label": "?", "reverse": True},
            {"kind": "text", "name": "c", "label": "?"},
        ],
    }
)


def sus(*answers: int) -> float | None:
    return score(SUS, {f"sus_{k}": str(value) for k, value in enumerate(answers, 1)})["sus_score"]


def test_the_raw_tlx_is_the_mean_of_its_six_scales() -> None:
    figures = (0, 20, 40, 60, 80, 100)
    answers = {item.name: str(f) for item, f in zip(TLX.items, figures, strict=True)}
    assert score(TLX, answers) == {"nasa_tlx_score": 50.0}
    assert score(TLX, answers | {"effort": "5"}) == {"nasa_tlx_score": (300 - 80 + 5) / 6}


@pytest.mark.parametrize(
    ("answers", "expected"),
    [
        ((5, 1, 5, 1, 5, 1, 5, 1, 5, 1), 100.0),
        ((1, 5, 1, 5, 1, 5, 1, 5, 1, 5), 0.0),
        ((3,) * 10, 50.0),
        ((5,) * 10, 50.0),
        ((4, 2, 4, 2, 4, 2, 4, 2, 4, 2), 75.0),
        ((5, 4, 2, 1, 2, 4, 2, 3, 2, 4), 2.5 * (4 + 1 + 1 + 4 + 1 + 1 + 1 + 2 + 1 + 1)),
    ],
)
def test_sus_by_its_definition(answers: tuple[int, ...], expected: float) -> None:
    """Odd items count value - 1, even items 5 - value; the sum times 2.5 [Brooke 1996]."""
    assert sus(*answers) == expected


@pytest.mark.parametrize("value", ["", DECLINED, "often"])
def test_nothing_is_filled_in_for_a_missing_answer(value: str) -> None:
    assert score(SUS, {f"sus_{k}": "3" for k in range(1, 11)} | {"sus_4": value}) == {
        "sus_score": None
    }
    assert score(TLX, {}) == {"nasa_tlx_score": None}


def test_a_mean_turns_reversed_items_round_and_leaves_texts_out() -> None:
    assert score(OWN, {"a": "3", "b": "1", "c": "hello"}) == {"own_score": 3.0}
    assert score(OWN, {"a": "1", "b": "1"}) == {"own_score": 2.0}


def test_scores_say_their_range() -> None:
    (tlx,) = scores_of(TLX)
    assert (tlx.name, tlx.lowest, tlx.highest) == ("nasa_tlx_score", 0.0, 100.0)
    assert scores_of(OWN) == (
        Score("own_score", 1.0, 3.0, "mean of the items, reversed ones turned round"),
    )
    assert scores_of(Instrument(use="paper-q1-q6")) == ()
    assert score(Instrument(use="paper-q1-q6"), {"Q1": "5"}) == {}
