"""What the export knows from the study itself: its items, and what a person's order implies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from study.config import Study
from study.protocol.device import FIELDS, FIGURES
from study.protocol.exclusions import ExclusionRule
from study.protocol.flow import step_kind
from study.protocol.questionnaires import (
    DECLINED,
    AgreeItem,
    ChoiceItem,
    Instrument,
    Item,
    NumberItem,
    ScaleItem,
    answer_label,
)
from study.records.codebook import ItemEntry

STEPS_ASKING = ("consent", "demographics", "questionnaire", "comments")
REPEATED = ("questionnaire",)
Row = dict[str, Any]


def instruments_of(study: Study, kind: str) -> tuple[Instrument, ...]:
    """What a kind of step asks."""
    one = study.instrument(kind)
    return () if one is None else (one,)


def rules_of(study: Study) -> tuple[ExclusionRule, ...]:
    """The exclusion rules that the study declares."""
    return tuple(getattr(study, "exclusion", ()))


def study_items(config_hash: str, study: Study) -> Iterator[ItemEntry]:
    """Every item that a version of a study asks, in the order of its pages."""
    for name in FIELDS:
        kind = "number" if name in FIGURES else "flag"
        yield ItemEntry(config_hash, "browser_check", name, kind, "measured by the browser check")
    for step in STEPS_ASKING:
        for instrument in instruments_of(study, step):
            for item in instrument.items:
                yield _entry(config_hash, instrument.name, item, step in REPEATED)


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
    for instrument in instruments_of(study, kind):
        for item in instrument.items:
            if item.name == row["item"]:
                row["instrument"] = instrument.name
                row["label"] = answer_label(item, row["value"])
                return


def _entry(config_hash: str, instrument: str, item: Item, repeated: bool) -> ItemEntry:
    levels: tuple[tuple[str, str], ...] = ()
    if isinstance(item, ScaleItem | ChoiceItem):
        levels = tuple((option.value, option.label) for option in item.options)
    elif isinstance(item, AgreeItem):
        levels = (("yes", "ticked"),)
    elif isinstance(item, NumberItem) and item.may_decline:
        levels = ((DECLINED, answer_label(item, DECLINED)),)
    whole = isinstance(item, NumberItem | ScaleItem) and all(_is_whole(v) for v, _ in levels)
    unit = item.unit if isinstance(item, NumberItem) else ""
    return ItemEntry(
        config_hash, instrument, item.name, item.kind, item.label, levels, unit, repeated, whole
    )


def _is_whole(value: str) -> bool:
    return value.removeprefix("-").isdecimal() and value.isascii()
