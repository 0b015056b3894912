"""Items, instruments and the one validator of answers.

An `Instrument` is a list of items that one page shows and records. `validate_answers` turns what a
form sent into stored text values, or raises `AnswerError` with one sentence per field. Columns of
every export come from these records, never from the answers seen.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from study.errors import AnswerError

DECLINED = "prefer_not_to_say"
DECLINED_SUFFIX = "_declined"
NAME_PATTERN = r"^[A-Za-z][A-Za-z0-9_]{0,39}$"


class Record(BaseModel):
    """Base of every record of a study file: frozen, and strangers are refused."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class Option(Record):
    """One answer that can be chosen: what is stored and what is shown."""

    value: Annotated[str, Field(min_length=1, max_length=40)]
    label: Annotated[str, Field(min_length=1, max_length=200)]


class ScaleItem(Record):
    """A statement with labelled points from low to high; exactly one is chosen."""

    kind: Literal["scale"] = "scale"
    name: Annotated[str, Field(pattern=NAME_PATTERN)]
    label: str
    help: str = ""
    required: bool = True
    options: Annotated[tuple[Option, ...], Field(min_length=2)]


class ChoiceItem(Record):
    """A question with unordered answers; exactly one is chosen."""

    kind: Literal["choice"] = "choice"
    name: Annotated[str, Field(pattern=NAME_PATTERN)]
    label: str
    help: str = ""
    required: bool = True
    options: Annotated[tuple[Option, ...], Field(min_length=2)]


class NumberItem(Record):
    """A whole number within bounds; `may_decline` adds a box “Prefer not to say”."""

    kind: Literal["number"] = "number"
    name: Annotated[str, Field(pattern=NAME_PATTERN)]
    label: str
    help: str = ""
    required: bool = True
    lowest: int
    highest: int
    unit: str = ""
    may_decline: bool = False

    @model_validator(mode="after")
    def _check_bounds(self) -> NumberItem:
        if self.lowest > self.highest:
            raise ValueError("`lowest` must not exceed `highest`")
        return self


class TextItem(Record):
    """Free text of at most `longest` characters."""

    kind: Literal["text"] = "text"
    name: Annotated[str, Field(pattern=NAME_PATTERN)]
    label: str
    help: str = ""
    required: bool = False
    longest: Annotated[int, Field(ge=1, le=10_000)] = 2000


class AgreeItem(Record):
    """A statement that must be ticked to go on."""

    kind: Literal["agree"] = "agree"
    name: Annotated[str, Field(pattern=NAME_PATTERN)]
    label: str
    help: str = ""
    required: bool = True


Item = Annotated[
    ScaleItem | ChoiceItem | NumberItem | TextItem | AgreeItem, Field(discriminator="kind")
]


class Instrument(Record):
    """A page's worth of items with its title and introduction."""

    name: Annotated[str, Field(pattern=NAME_PATTERN)]
    title: str
    introduction: str = ""
    items: tuple[Item, ...] = ()

    @model_validator(mode="after")
    def _check_names(self) -> Instrument:
        names = [item.name for item in self.items]
        taken = names + [
            item.name + DECLINED_SUFFIX
            for item in self.items
            if isinstance(item, NumberItem) and item.may_decline
        ]
        if len(set(taken)) != len(taken):
            raise ValueError("every item of an instrument needs a name of its own")
        return self


def validate_answers(instrument: Instrument, form: Mapping[str, str]) -> dict[str, str]:
    """Stored values by item name, in the instrument's order; raises `AnswerError`.

    An optional item left empty is stored as the empty string, so that “shown and left empty” can be
    told from “never shown”. Fields that belong to no item are ignored.
    """
    answers: dict[str, str] = {}
    problems: dict[str, str] = {}
    for item in instrument.items:
        try:
            answers[item.name] = _validate_item(item, form)
        except ValueError as problem:
            problems[item.name] = str(problem)
    if problems:
        raise AnswerError(problems)
    return answers


def answer_label(item: Item, value: str) -> str:
    """What the participant saw for a stored value (the value itself where nothing else was)."""
    if value == DECLINED:
        return "Prefer not to say"
    if isinstance(item, ScaleItem | ChoiceItem):
        return next((option.label for option in item.options if option.value == value), value)
    return value


def _validate_item(item: Item, form: Mapping[str, str]) -> str:
    raw = form.get(item.name, "")
    if isinstance(item, ScaleItem | ChoiceItem):
        return _validate_choice(item, raw)
    if isinstance(item, NumberItem):
        return _validate_number(item, raw.strip(), form.get(item.name + DECLINED_SUFFIX, "") != "")
    if isinstance(item, TextItem):
        return _validate_text(item, raw)
    if raw != "yes":
        raise ValueError("Please tick this box if you want to go on.")
    return "yes"


def _validate_choice(item: ScaleItem | ChoiceItem, raw: str) -> str:
    if raw in {option.value for option in item.options}:
        return raw
    if raw == "" and not item.required:
        return ""
    raise ValueError("Please choose one of the answers.")


def _validate_number(item: NumberItem, raw: str, declined: bool) -> str:
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
    if not (raw.isascii() and raw.isdecimal() and len(raw) <= 9):
        raise ValueError(f"Please enter {bounds}.")
    if not item.lowest <= int(raw) <= item.highest:
        raise ValueError(f"Please enter {bounds}.")
    return str(int(raw))


def _validate_text(item: TextItem, raw: str) -> str:
    text = raw.replace("\r\n", "\n").replace("\r", "\n").replace("\x00", "").strip()
    if text == "" and item.required:
        raise ValueError("Please write something here.")
    if len(text) > item.longest:
        raise ValueError(
            f"Please shorten this to {item.longest} characters; it has {len(text)} now."
        )
    return text
