"""Instruments: groups of items with their introduction, order, scoring and source.

Columns of every export come from these records, never from the answers seen. An instrument of the
library is taken with `use`; its items are copied into the study, so that a later edition of the
library changes no running study.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from study.protocol.instruments.library import NAMES, find_instrument
from study.protocol.items import DECLINED_SUFFIX, ChoiceItem, Item, NumberItem, ScaleItem
from study.protocol.items import Points as Points
from study.protocol.records import NAME_PATTERN, Problem, Record, find_twins, refuse

Scoring = Literal["none", "mean", "nasa-tlx-raw", "sus"]
Placement = Literal["each-trial", "end"]


class Instrument(Record):
    """A group of items that one page shows and records.

    `use` names an instrument of the library, whose other entries may be overridden but for its
    items. `options` are the points of scale items that bring none of their own.
    """

    use: str = ""
    name: Annotated[str, Field(pattern=NAME_PATTERN)] = "unnamed"
    title: Annotated[str, Field(max_length=200)] = ""
    introduction: Annotated[str, Field(max_length=5000)] = ""
    options: Points = ()
    items: tuple[Item, ...] = ()
    random_order: bool = False
    scoring: Scoring = "none"
    source: Annotated[str, Field(max_length=2000)] = ""

    @model_validator(mode="before")
    @classmethod
    def _take_from_library(cls, given: Any) -> Any:
        if not isinstance(given, Mapping):
            return given
        entries = dict(given)
        if entries.get("use") and "items" not in entries:
            if entries["use"] not in NAMES:
                names = ", ".join(NAMES)
                message = f"the library has no such instrument; it has {names}"
                refuse([Problem(("use",), entries["use"], message)])
            entries = {**find_instrument(entries["use"]), **entries}
        return _freeze(_hand_down_options(entries))

    @model_validator(mode="after")
    def _check_items(self) -> Instrument:
        problems = [
            Problem(
                ("items", later, "name"),
                self.items[later].name,
                f"item {first} has this name already; every item needs a name of its own",
            )
            for later, first in find_twins([item.name for item in self.items])
        ]
        for number, item in enumerate(self.items):
            if isinstance(item, ScaleItem | ChoiceItem):
                problems += _check_options(number, item)
        refuse(problems + _check_declines(self.items))
        return self

    def arranged(self, study_seed: int, participant_code: str) -> Instrument:
        """The instrument as one participant sees it: the same order each time they meet it."""
        if not self.random_order:
            return self

        def draw(item: Item) -> bytes:
            parts = ("items", str(study_seed), participant_code, self.name, item.name)
            return hashlib.sha256("\x1f".join(parts).encode()).digest()

        return self.model_copy(update={"items": tuple(sorted(self.items, key=draw))})


class Questionnaire(Instrument):
    """An instrument with its place: after each trial, or once at the end."""

    place: Placement = "each-trial"


def _freeze(value: Any) -> Any:
    """The same value with tuples for lists, as strict validation wants it."""
    if isinstance(value, Mapping):
        return {key: _freeze(inner) for key, inner in value.items()}
    return tuple(_freeze(inner) for inner in value) if isinstance(value, list | tuple) else value


def _hand_down_options(entries: dict[str, Any]) -> dict[str, Any]:
    """Give scale items without options of their own the instrument's."""
    items, options = entries.get("items"), entries.get("options")
    if not options or not isinstance(items, list | tuple):
        return entries

    def complete(item: Any) -> Any:
        if not isinstance(item, Mapping) or item.get("kind", "scale") != "scale":
            return item
        return {**item, "options": item.get("options") or options}

    return {**entries, "items": [complete(item) for item in items]}


def _check_options(number: int, item: ScaleItem | ChoiceItem) -> list[Problem]:
    place = ("items", number, "options")
    if len(item.options) < 2:
        return [Problem(place, len(item.options), "give at least two options to choose from")]
    return [
        Problem(
            (*place, later, "value"),
            item.options[later].value,
            f"option {first} stores this value already",
        )
        for later, first in find_twins([option.value for option in item.options])
    ]


def _check_declines(items: tuple[Item, ...]) -> list[Problem]:
    """The box “prefer not to say” is a field of the form too."""
    taken = {
        item.name + DECLINED_SUFFIX
        for item in items
        if isinstance(item, NumberItem) and item.may_decline
    }
    return [
        Problem(("items", number, "name"), item.name, "a box of another item has this name already")
        for number, item in enumerate(items)
        if item.name in taken
    ]
