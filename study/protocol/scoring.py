"""Scores of instruments, computed from stored answers.

An answer that is missing, empty or declined leaves the score missing: nothing is filled in.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from study.protocol.items import DECLINED, RatingItem, ScaleItem, SliderItem
from study.protocol.questionnaires import Instrument

SUS_FACTOR = 2.5
Scored = ScaleItem | RatingItem | SliderItem


@dataclass(frozen=True)
class Score:
    """One score of an instrument: its column, its range and what it means."""

    name: str
    lowest: float
    highest: float
    meaning: str


def scores_of(instrument: Instrument) -> tuple[Score, ...]:
    """The scores that an instrument has; empty where items are analysed one by one."""
    name = f"{instrument.name}_score"
    if instrument.scoring == "nasa-tlx-raw":
        return (Score(name, 0.0, 100.0, "mean of the six scales without weights (raw TLX)"),)
    if instrument.scoring == "sus":
        return (Score(name, 0.0, 100.0, "System Usability Scale, 0 worst to 100 best"),)
    if instrument.scoring == "mean":
        lowest, highest = _ends(_scored_items(instrument)[0]) or (0.0, 0.0)
        return (Score(name, lowest, highest, "mean of the items, reversed ones turned round"),)
    return ()


def score(instrument: Instrument, answers: Mapping[str, str]) -> dict[str, float | None]:
    """The instrument's scores by name from stored answers by item; None where one is missing."""
    columns = scores_of(instrument)
    if not columns:
        return {}
    figures = [_turned(item, answers.get(item.name, "")) for item in _scored_items(instrument)]
    known = [figure for figure in figures if figure is not None]
    if len(known) < len(figures):
        return {columns[0].name: None}
    if instrument.scoring == "sus":
        return {columns[0].name: SUS_FACTOR * sum(figure - 1.0 for figure in known)}
    return {columns[0].name: sum(known) / len(known)}


def scoring_problem(instrument: Instrument) -> str:
    """Why an instrument cannot be scored as it says, or an empty text."""
    if instrument.scoring == "none":
        return ""
    ends = [_ends(item) for item in _scored_items(instrument)]
    if not ends:
        return "nothing can be scored without scale, rating or slider items"
    if None in ends:
        return "scored scale items must store whole numbers"
    if len(set(ends)) > 1:
        return "items that are scored together need the same lowest and highest value"
    if instrument.scoring == "sus" and (len(ends), ends[0]) != (10, (1.0, 5.0)):
        return "`sus` needs its ten items, answered from 1 to 5"
    if instrument.scoring == "nasa-tlx-raw" and (len(ends), ends[0]) != (6, (0.0, 100.0)):
        return "`nasa-tlx-raw` needs its six scales, answered from 0 to 100"
    return ""


def _scored_items(instrument: Instrument) -> list[Scored]:
    return [item for item in instrument.items if isinstance(item, Scored)]


def _ends(item: Scored) -> tuple[float, float] | None:
    """The lowest and highest figure of an item; None if its options store no figures."""
    if isinstance(item, RatingItem | SliderItem):
        return float(item.lowest), float(item.highest)
    values = [option.value for option in item.options if option.value != DECLINED]
    if not values or not all(value.isascii() and value.isdecimal() for value in values):
        return None
    figures = [float(value) for value in values]
    return min(figures), max(figures)


def _turned(item: Scored, value: str) -> float | None:
    """The answer as a figure, turned round on a reversed item; None if there is no figure."""
    ends = _ends(item)
    try:
        figure = float(value)
    except ValueError:
        return None
    if ends is None:
        return None
    return ends[0] + ends[1] - figure if item.reverse else figure
