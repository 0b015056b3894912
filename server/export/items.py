"""What the export knows from the study itself: its items, and what a person's order implies."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from study.config import Study
from study.protocol.device import FIELDS, FIGURES
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
    unit_of,
)
from study.protocol.scoring import score, scores_of
from study.records.codebook import SCORE, ItemEntry

STEPS_ASKING = ("consent", "demographics", "questionnaire", "final", "comments")
REPEATED = ("questionnaire",)
Row = dict[str, Any]


def study_items(config_hash: str, study: Study) -> Iterator[ItemEntry]:
    """Every item that a version of a study asks, in the order of its pages, and its scores."""
    for name in FIELDS:
        kind = "number" if name in FIGURES else "flag"
        yield ItemEntry(config_hash, "browser_check", name, kind, "measured by the browser check")
    for step in STEPS_ASKING:
        repeated = step in REPEATED
        for instrument in study.instruments(step):
            for item in instrument.items:
                yield _entry(config_hash, instrument.name, item, repeated)
            for one in scores_of(instrument):
                meaning = f"{one.meaning}; from {one.lowest:g} to {one.highest:g}"
                yield ItemEntry(
                    config_hash, instrument.name, SCORE, SCORE, meaning, repeated=repeated
                )


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
            return


def score_answers(study: Study, answers: Iterable[Row]) -> list[Row]:
    """The scores of one person's completed answers, as rows of the same shape."""
    given: dict[tuple[str, str | None], dict[str, str]] = {}
    for row in answers:
        given.setdefault((row["instrument"], row["condition"]), {})[row["item"]] = row["value"]
    scored = [one for one in study.all_instruments if scores_of(one)]
    return [
        {"instrument": one.name, "item": SCORE, "condition": condition, "value": figure}
        for one in scored
        for (name, condition), values in given.items()
        if name == one.name
        for figure in score(one, values).values()
    ]


def _entry(config_hash: str, instrument: str, item: Item, repeated: bool) -> ItemEntry:
    levels = levels_of(item)
    if isinstance(item, NumberItem) and item.may_decline:
        levels = (*levels, (DECLINED, answer_label(item, DECLINED)))
    kinds = NumberItem | ScaleItem | RatingItem | SliderItem
    whole = isinstance(item, kinds) and all(_is_whole(value) for value, _ in levels)
    unit = unit_of(item)
    return ItemEntry(
        config_hash, instrument, item.name, item.kind, item.label, levels, unit, repeated, whole
    )


def _is_whole(value: str) -> bool:
    return value.removeprefix("-").isdecimal() and value.isascii()
