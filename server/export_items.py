"""What the export knows from the study itself: its items, and what a person's order implies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from study.config import Study
from study.protocol.device import FIELDS, FIGURES
from study.protocol.exclusions import ExclusionRule
from study.protocol.flow import step_kind
from study.protocol.items import (
    DECLINED,
    Item,
    NumberItem,
    RatingItem,
    ScaleItem,
    SliderItem,
    answer_label,
    levels_of,
    may_decline,
    unit_of,
)
from study.protocol.questionnaires import Instrument, Questionnaire
from study.records.codebook import ItemEntry

Row = dict[str, Any]


def rules_of(study: Study) -> tuple[ExclusionRule, ...]:
    """The exclusion rules that the study declares."""
    return study.exclusion


def study_items(config_hash: str, study: Study) -> Iterator[ItemEntry]:
    """Every item that a version of a study asks, in the order of its pages."""
    for name in FIELDS:
        kind = "number" if name in FIGURES else "flag"
        yield ItemEntry(config_hash, "browser_check", name, kind, "measured by the browser check")
    for instrument in study.all_instruments:
        for item in instrument.items:
            yield _entry(config_hash, instrument, item)


def all_conditions(versions: Mapping[str, Study]) -> list[str]:
    """The conditions of all versions, in the order of their first appearance."""
    return list(dict.fromkeys(name for study in versions.values() for name in study.conditions))


def complete_person(row: Row, study: Study) -> None:
    """Add the order of the conditions."""
    order = row["order_index"]
    row["condition_order"] = None if order is None else ">".join(study.orders[order])


def complete_answer(row: Row, study: Study) -> None:
    """Add position, condition, instrument and the wording of an answer."""
    kind, position = step_kind(row["step"])
    order = row["order_index"]
    known = position is not None and order is not None
    row["position"] = position
    row["condition"] = study.orders[order][position - 1] if known and position else None
    row["instrument"], row["label"] = kind.replace("-", "_"), row["value"]
    for instrument, item in study.items_asked(kind):
        if item.name == row["item"]:
            row["instrument"] = instrument.name
            row["label"] = answer_label(item, row["value"])


def _entry(config_hash: str, instrument: Instrument, item: Item) -> ItemEntry:
    levels = levels_of(item)
    if isinstance(item, NumberItem) and may_decline(item):
        levels = ((DECLINED, answer_label(item, DECLINED)),)
    numeric = isinstance(item, NumberItem | ScaleItem | RatingItem | SliderItem)
    return ItemEntry(
        config_hash,
        instrument.name,
        item.name,
        item.kind,
        item.label,
        levels,
        unit_of(item),
        isinstance(instrument, Questionnaire) and instrument.place == "each-trial",
        numeric and all(_is_whole(value) for value, _ in levels),
    )


def _is_whole(value: str) -> bool:
    return value.removeprefix("-").isdecimal() and value.isascii()
