"""The kinds of items: what one question looks like and which answers it offers."""

from __future__ import annotations

import re
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator

from study.protocol.records import NAME_PATTERN, Record

DECLINED = "prefer_not_to_say"
DECLINED_SUFFIX = "_declined"
MOST_POINTS = 21
_NO_WORD = re.compile(r"[^a-z0-9]+")

ItemName = Annotated[str, Field(pattern=NAME_PATTERN)]
ItemText = Annotated[str, Field(min_length=1, max_length=1000)]
Anchor = Annotated[str, Field(max_length=200)]


class Option(Record):
    """One answer that can be chosen: what is stored and what is shown."""

    value: Annotated[str, Field(min_length=1, max_length=40)]
    label: Annotated[str, Field(min_length=1, max_length=200)]


def _number_options(options: Any) -> Any:
    """Plain texts stand for the points 1, 2, 3 ..."""
    return _spread(options, lambda number, _: str(number))


def _name_options(options: Any) -> Any:
    """Plain texts stand for options whose stored value is made from the text."""
    return _spread(options, lambda _, text: _NO_WORD.sub("_", text.lower()).strip("_")[:40])


def _spread(options: Any, value_for: Any) -> Any:
    if not isinstance(options, list | tuple):
        return options
    return tuple(
        {"value": value_for(number, entry), "label": entry} if isinstance(entry, str) else entry
        for number, entry in enumerate(options, 1)
    )


Points = Annotated[
    tuple[Option, ...],
    BeforeValidator(_number_options, json_schema_input_type=tuple[str | Option, ...]),
]
Choices = Annotated[
    tuple[Option, ...],
    BeforeValidator(_name_options, json_schema_input_type=tuple[str | Option, ...]),
]


class ScaleItem(Record):
    """A statement with labelled points from low to high (Likert); exactly one is chosen.

    Without `options` the instrument's are taken. `reverse`: agreement counts against the score.
    """

    kind: Literal["scale"] = "scale"
    name: ItemName
    label: ItemText
    help: str = ""
    required: bool = True
    options: Points = ()
    reverse: bool = False


class RatingItem(Record):
    """Numbered points between two anchors, e.g. the 21 steps of the NASA-TLX: 0 to 100 by 5."""

    kind: Literal["rating"] = "rating"
    name: ItemName
    label: ItemText
    help: str = ""
    required: bool = True
    lowest: int = 1
    highest: int = 7
    step: Annotated[int, Field(ge=1)] = 1
    low: Anchor
    high: Anchor
    reverse: bool = False

    @model_validator(mode="after")
    def _check_points(self) -> RatingItem:
        _check_grid(self)
        if len(self.points) > MOST_POINTS:
            raise ValueError(f"at most {MOST_POINTS} points, not {len(self.points)}; use a slider")
        return self

    @property
    def points(self) -> tuple[int, ...]:
        """The values from low to high."""
        return tuple(range(self.lowest, self.highest + 1, self.step))


class SliderItem(Record):
    """A slider between two anchors; it counts as answered only once it was moved or typed into."""

    kind: Literal["slider"] = "slider"
    name: ItemName
    label: ItemText
    help: str = ""
    required: bool = True
    lowest: int = 0
    highest: int = 100
    step: Annotated[int, Field(ge=1)] = 1
    low: Anchor
    high: Anchor
    unit: Anchor = ""
    reverse: bool = False

    @model_validator(mode="after")
    def _check_points(self) -> SliderItem:
        _check_grid(self)
        return self


class ChoiceItem(Record):
    """A question with unordered answers; exactly one is chosen."""

    kind: Literal["choice"] = "choice"
    name: ItemName
    label: ItemText
    help: str = ""
    required: bool = True
    options: Choices = ()


class NumberItem(Record):
    """A whole number within bounds; `may_decline` adds a box “Prefer not to say”."""

    kind: Literal["number"] = "number"
    name: ItemName
    label: ItemText
    help: str = ""
    required: bool = True
    lowest: Annotated[int, Field(ge=-999_999_999)]
    highest: Annotated[int, Field(le=999_999_999)]
    unit: Anchor = ""
    may_decline: bool = False

    @model_validator(mode="after")
    def _check_bounds(self) -> NumberItem:
        if self.lowest > self.highest:
            raise ValueError("`lowest` must not exceed `highest`")
        return self


class TextItem(Record):
    """Free text of at most `longest` characters."""

    kind: Literal["text"] = "text"
    name: ItemName
    label: ItemText
    help: str = ""
    required: bool = False
    longest: Annotated[int, Field(ge=1, le=10_000)] = 2000


class AgreeItem(Record):
    """A statement that must be ticked to go on."""

    kind: Literal["agree"] = "agree"
    name: ItemName
    label: ItemText
    help: str = ""
    required: Literal[True] = True


Item = Annotated[
    ScaleItem | RatingItem | SliderItem | ChoiceItem | NumberItem | TextItem | AgreeItem,
    Field(discriminator="kind"),
]
Optioned = ScaleItem | ChoiceItem
Stepped = RatingItem | SliderItem


def _check_grid(item: Stepped) -> None:
    if item.lowest >= item.highest:
        raise ValueError("`lowest` must be below `highest`")
    if (item.highest - item.lowest) % item.step:
        raise ValueError("`step` must divide the way from `lowest` to `highest`")


def levels_of(item: Item) -> tuple[tuple[str, str], ...]:
    """Stored values with what they are called; of stepped items only the two ends have a name."""
    if isinstance(item, ScaleItem | ChoiceItem):
        return tuple((option.value, option.label) for option in item.options)
    if isinstance(item, RatingItem | SliderItem):
        return ((str(item.lowest), item.low), (str(item.highest), item.high))
    return (("yes", "ticked"),) if isinstance(item, AgreeItem) else ()


def unit_of(item: Item) -> str:
    """The unit of an item's value, or an empty text."""
    return item.unit if isinstance(item, NumberItem | SliderItem) else ""


def may_decline(item: Item) -> bool:
    """Whether the item offers not to answer it."""
    if isinstance(item, NumberItem):
        return item.may_decline
    return isinstance(item, ChoiceItem | ScaleItem) and any(
        option.value == DECLINED for option in item.options
    )


def answer_label(item: Item, value: str) -> str:
    """What the participant saw for a stored value (the value itself where nothing else was)."""
    if value == DECLINED:
        return "Prefer not to say"
    if isinstance(item, ScaleItem | ChoiceItem):
        return next((option.label for option in item.options if option.value == value), value)
    return value
