"""The one validator of answers: what a form sent becomes stored text values, or sentences.

Every refusal names its field, and nothing is stored of a form that has one.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from study.errors import AnswerError
from study.protocol.items import (
    DECLINED,
    DECLINED_SUFFIX,
    ChoiceItem,
    Item,
    NumberItem,
    Optioned,
    RatingItem,
    ScaleItem,
    SliderItem,
    Stepped,
    TextItem,
)


def validate_answers(items: Iterable[Item], form: Mapping[str, str]) -> dict[str, str]:
    """Stored values by item name, in the order of the items; raises `AnswerError`.

    An optional item left empty is stored as the empty string, so that “shown and left empty” can be
    told from “never shown”. Fields that belong to no item are ignored.
    """
    answers: dict[str, str] = {}
    problems: dict[str, str] = {}
    for item in items:
        try:
            answers[item.name] = value_of(item, form)
        except ValueError as problem:
            problems[item.name] = str(problem)
    if problems:
        raise AnswerError(problems)
    return answers


def value_of(item: Item, form: Mapping[str, str]) -> str:
    """The value to store for one item. Errors: ValueError with a sentence for the participant."""
    raw = form.get(item.name, "")
    if isinstance(item, ScaleItem | ChoiceItem):
        return _read_choice(item, raw)
    if isinstance(item, RatingItem | SliderItem):
        return _read_step(item, raw.strip())
    if isinstance(item, NumberItem):
        return _read_number(item, raw.strip(), form.get(item.name + DECLINED_SUFFIX, "") != "")
    if isinstance(item, TextItem):
        return _read_text(item, raw)
    if raw != "yes":
        raise ValueError("Please tick this box if you want to go on.")
    return "yes"


def _read_choice(item: Optioned, raw: str) -> str:
    if raw in {option.value for option in item.options}:
        return raw
    if raw == "" and not item.required:
        return ""
    raise ValueError("Please choose one of the answers.")


def _read_step(item: Stepped, raw: str) -> str:
    if raw == "" and not item.required:
        return ""
    figure = _read_whole(raw)
    on_grid = figure is not None and (figure - item.lowest) % item.step == 0
    if figure is None or not on_grid or not item.lowest <= figure <= item.highest:
        if isinstance(item, RatingItem):
            raise ValueError("Please choose one of the points.")
        bounds = f"{item.lowest} to {item.highest}"
        steps = f" in steps of {item.step}" if item.step > 1 else ""
        raise ValueError(f"Please move the slider, or enter a number from {bounds}{steps}.")
    return str(figure)


def _read_number(item: NumberItem, raw: str, declined: bool) -> str:
    bounds = f"a whole number from {item.lowest} to {item.highest}"
    if declined and item.may_decline:
        if raw:
            raise ValueError("Please either give a number or tick “Prefer not to say”, not both.")
        return DECLINED
    if raw == "":
        if not item.required:
            return ""
        also = ", or tick “Prefer not to say”" if item.may_decline else ""
        raise ValueError(f"Please enter {bounds}{also}.")
    figure = _read_whole(raw)
    if figure is None or not item.lowest <= figure <= item.highest:
        raise ValueError(f"Please enter {bounds}.")
    return str(figure)


def _read_whole(raw: str) -> int | None:
    """A whole number of at most nine ASCII digits, or None."""
    digits = raw.removeprefix("-")
    if digits.isascii() and digits.isdecimal() and len(digits) <= 9:
        return int(raw)
    return None


def _read_text(item: TextItem, raw: str) -> str:
    text = raw.replace("\r\n", "\n").replace("\r", "\n").replace("\x00", "").strip()
    if text == "" and item.required:
        raise ValueError("Please write something here.")
    if len(text) > item.longest:
        raise ValueError(
            f"Please shorten this to {item.longest} characters; it has {len(text)} now."
        )
    return text
