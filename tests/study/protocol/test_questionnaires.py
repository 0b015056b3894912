"""Guards the validator: only allowed answers are stored, and every refusal names its field."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from study.errors import AnswerError
from study.protocol.answers import validate_answers
from study.protocol.device import judge_device
from study.protocol.items import DECLINED, TextItem, answer_label, may_decline
from study.protocol.questionnaires import Instrument

QUESTIONNAIRE = Instrument(use="paper-q1-q6")
DEMOGRAPHICS = Instrument(use="demographics")
CONSENT = Instrument(use="consent")
FULL = {f"Q{k}": str(k % 5 + 1) for k in range(1, 7)}
PERSON = {"age": "31", "gender": "woman", "games_3d": "never", "colour_vision": "no"}
DEVICE = {
    "keyboard": "yes",
    "mouse": "yes",
    "webgl": "yes",
    "touch_only": "no",
    "frame_rate_hz": "59.94",
    "latency_ms": "12",
}


def problems(instrument: Instrument, form: dict[str, str]) -> dict[str, str]:
    with pytest.raises(AnswerError) as caught:
        validate_answers(instrument.items, form)
    return caught.value.problems


def test_the_paper_items_and_points_are_verbatim() -> None:
    items = QUESTIONNAIRE.items
    assert [item.name for item in items] == ["Q1", "Q2", "Q3", "Q4", "Q5", "Q6"]
    assert items[3].label == "It was easy to keep track of robot status."
    assert [option.label for option in items[0].options] == [
        "Strongly disagree",
        "Somewhat disagree",
        "Neutral",
        "Somewhat agree",
        "Strongly agree",
    ]


def test_full_answers_are_stored_in_the_order_of_the_items() -> None:
    backwards = dict(reversed(FULL.items())) | {"stranger": "1"}
    assert list(validate_answers(QUESTIONNAIRE.items, backwards).items()) == list(FULL.items())


@given(st.text(max_size=5).filter(lambda value: value not in {"1", "2", "3", "4", "5"}))
def test_nothing_off_the_scale_is_stored(value: str) -> None:
    assert set(problems(QUESTIONNAIRE, FULL | {"Q3": value})) == {"Q3"}


def test_every_missing_answer_is_named() -> None:
    assert set(problems(QUESTIONNAIRE, {"Q1": "1"})) == {"Q2", "Q3", "Q4", "Q5", "Q6"}


@pytest.mark.parametrize("age", ["", "17", "121", "-30", "3.5", "thirty", "１８", "9" * 400, "+30"])
def test_an_age_that_cannot_be_is_refused(age: str) -> None:
    assert set(problems(DEMOGRAPHICS, PERSON | {"age": age})) == {"age"}


def test_an_age_may_be_declined_but_not_both_given_and_declined() -> None:
    declined = PERSON | {"age": "", "age_declined": "yes"}
    assert validate_answers(DEMOGRAPHICS.items, declined)["age"] == DECLINED
    assert "age" in problems(DEMOGRAPHICS, PERSON | {"age_declined": "yes"})


def test_every_question_about_the_person_may_be_declined() -> None:
    for item in DEMOGRAPHICS.items:
        assert may_decline(item), item.name


def test_consent_needs_every_box() -> None:
    assert set(problems(CONSENT, {"adult": "yes", "informed": "no"})) == {
        "informed",
        "agreed",
    }


def test_texts_keep_their_lines_lose_what_no_database_takes_and_have_an_end() -> None:
    instrument = Instrument(name="i", title="t", items=(TextItem(name="a", label="?", longest=5),))
    assert validate_answers(instrument.items, {"a": " a\r\nb\x00 "}) == {"a": "a\nb"}
    assert validate_answers(instrument.items, {}) == {"a": ""}
    assert "has 6 now" in problems(instrument, {"a": "123456"})["a"]


def test_two_items_of_one_name_are_refused() -> None:
    item = TextItem(name="a", label="?")
    with pytest.raises(ValidationError, match="a name of its own"):
        Instrument(name="i", title="t", items=(item, item))


def test_an_answer_has_the_label_that_was_shown() -> None:
    assert answer_label(QUESTIONNAIRE.items[0], "2") == "Somewhat disagree"
    assert answer_label(DEMOGRAPHICS.items[0], DECLINED) == "Prefer not to say"
    assert answer_label(DEMOGRAPHICS.items[0], "31") == "31"


def test_a_device_that_will_do_is_recorded() -> None:
    assert judge_device(DEVICE) == DEVICE | {"frame_rate_hz": "59.9", "latency_ms": "12.0"}


@pytest.mark.parametrize(
    ("change", "field", "advice"),
    [
        ({"webgl": "no"}, "webgl", "another browser"),
        ({"touch_only": "yes"}, "touch_only", "keyboard and a mouse"),
        ({"webgl": ""}, "webgl", "JavaScript"),
        ({"keyboard": "no"}, "keyboard", "press"),
        ({"mouse": ""}, "mouse", "move the mouse"),
    ],
)
def test_a_device_that_will_not_do_is_told_why(
    change: dict[str, str], field: str, advice: str
) -> None:
    with pytest.raises(AnswerError) as caught:
        judge_device(DEVICE | change)
    assert advice in caught.value.problems[field]


@pytest.mark.parametrize("figure", ["", "NaN", "inf", "-1", "x", "1e9"])
def test_a_figure_that_could_not_be_measured_is_left_empty(figure: str) -> None:
    assert judge_device(DEVICE | {"latency_ms": figure})["latency_ms"] == ""
