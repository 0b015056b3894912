"""What an analysis works on: the people, trials and answers of one mode of one study.

The rule of complete cases: a participant counts for a team measure with a completed trial and a
figure in every condition, and for an item with an answer after every condition, whatever page the
participation ended on. Excluded participants never count. Withdrawn ones have no data.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType

import numpy as np

from study.analysis.designs import Design, LeftOut, Reading, complete_cases, order_conditions
from study.analysis.wording import NO_VALUE

MEASURES: Mapping[str, str] = MappingProxyType(
    {
        "sum_wait_s": "total waiting time",
        "sum_completion_s": "sum of completion times",
        "slowest_robot_s": "time of the slowest robot",
    }
)
"""The team measures by column of trials.csv, in seconds."""
MARKS: Mapping[str, str] = MappingProxyType(
    {
        "live": "",
        "pilot": "pilot data",
        "bot": "simulated participants (bots)",
        "": "no data",
    }
)
"""What every page and figure says about the mode; nothing for live data."""
SCORE = "score"
"""Kind and name of an item that is an instrument's score."""
_RATED = frozenset({"scale", "rating", "slider", "number", SCORE})
_TO_Q6 = ("Q2", "Q3", "Q4", "Q5", "Q6")
_NAMED = ("varil", "arroch", "crmiar")


@dataclass(frozen=True)
class Person:
    """A participant; `excluded` is the reason, empty for those who count."""

    code: str
    status: str
    order: str = ""
    excluded: str = ""


@dataclass(frozen=True)
class TrialCase:
    """A trial; a measure without a figure is missing from `values`.

    `marked` names the exclusion rules that it breaks; such a trial does not count, nor do the
    answers after it.
    """

    participant: str
    condition: str
    position: int
    status: str
    values: Mapping[str, float]
    marked: str = ""


@dataclass(frozen=True)
class Item:
    """An item as the codebook lists it; `levels` are (value, label) from low to high."""

    instrument: str
    name: str
    kind: str
    wording: str
    levels: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Answer:
    """An answer as it is stored; `condition` is empty for a question asked once."""

    participant: str
    condition: str
    position: int | None
    instrument: str
    item: str
    value: str


@dataclass(frozen=True)
class StudyData:
    """Everything of one mode of a study; how much exclusion rules mark, and whether it is kept."""

    study_id: str
    mode: str
    versions: tuple[str, ...]
    people: tuple[Person, ...]
    trials: tuple[TrialCase, ...]
    answers: tuple[Answer, ...]
    items: tuple[Item, ...]
    marked_people: int = 0
    marked_trials: int = 0
    keeps_marked: bool = False

    @property
    def mark(self) -> str:
        """Whose data these are; empty for live participants."""
        return MARKS.get(self.mode, self.mode)

    @property
    def mode_filter(self) -> str:
        """The filter that chose these rows, as tables name it."""
        return f"mode = {self.mode or NO_VALUE}"

    @cached_property
    def counted(self) -> tuple[str, ...]:
        """Codes of participants who are not excluded, in the order of the file."""
        return tuple(person.code for person in self.people if not person.excluded)

    @cached_property
    def conditions(self) -> tuple[str, ...]:
        """Conditions met or planned by anybody, `varil` first."""
        met = [trial.condition for trial in self.trials]
        met += [name for person in self.people for name in person.order.split(">") if name]
        return order_conditions(met)

    @cached_property
    def rated_items(self) -> tuple[Item, ...]:
        """Items with ordered answers that were asked after trials, in the codebook's order."""
        asked = {(one.instrument, one.item) for one in self.answers if one.condition}
        found = (item for item in self.items if (item.instrument, item.name) in asked)
        return tuple(item for item in found if item.kind in _RATED)


def team_design(data: StudyData, measure: str) -> Design:
    """Complete cases of a team measure."""
    counted = set(data.counted)
    readings: list[Reading] = []
    reasons: dict[tuple[str, str], str] = {}
    for trial in data.trials:
        if trial.participant not in counted:
            continue
        value = trial.values.get(measure)
        place = (trial.participant, trial.condition)
        if trial.marked:
            reasons[place] = f"trial {trial.position} {trial.marked}"
        elif trial.status != "completed":
            reasons[place] = f"trial {trial.position} {trial.status or 'without status'}"
        elif value is None:
            reasons[place] = f"trial {trial.position} has no {measure}"
        else:
            readings.append(Reading(*place, trial.position, value))
    missing = {(code, name): "no trial" for code in data.counted for name in data.conditions}
    return complete_cases(measure, readings, data.conditions, data.counted, missing | reasons)


def item_design(data: StudyData, item: Item) -> Design:
    """Complete cases of an item; answers that are no number or level count as missing."""
    counted = set(data.counted)
    places = level_places(item)
    marked = {
        (trial.participant, trial.condition): f"trial {trial.position} {trial.marked}"
        for trial in data.trials
        if trial.marked
    }
    readings: list[Reading] = []
    for answer in data.answers:
        if (answer.instrument, answer.item) != (item.instrument, item.name):
            continue
        value = read_level(answer.value, places)
        usable = answer.condition and (answer.participant, answer.condition) not in marked
        if usable and answer.participant in counted and value is not None:
            place = (answer.participant, answer.condition, answer.position or 0)
            readings.append(Reading(*place, value))
    missing = {(code, name): "no answer" for code in data.counted for name in data.conditions}
    missing |= marked
    return complete_cases(item.name, readings, data.conditions, data.counted, missing)


def level_places(item: Item) -> dict[str, float]:
    """The place of each level by its value, from 1."""
    return {value: float(place) for place, (value, _) in enumerate(item.levels, 1)}


def scale_points(item: Item) -> tuple[tuple[float, str], ...]:
    """The levels as numbers with their labels; none for an open scale."""
    places = level_places(item)
    read = ((read_level(value, places), label) for value, label in item.levels)
    return tuple((value, label) for value, label in read if value is not None)


def read_level(text: str, places: Mapping[str, float]) -> float | None:
    """An answer as a number: its own, else the place of its level (from 1), else None."""
    try:
        value = float(text)
    except ValueError:
        return places.get(text)
    return value if np.isfinite(value) else None


def correction_family(items: tuple[Item, ...], instrument: str) -> tuple[str, ...]:
    """The items corrected together: Q2 to Q6 where they exist, else all of the instrument."""
    names = tuple(
        item.name for item in items if item.instrument == instrument and item.kind != SCORE
    )
    return _TO_Q6 if set(_TO_Q6) <= set(names) else names


def everyone_left_out(data: StudyData, design: Design) -> tuple[LeftOut, ...]:
    """Excluded participants with their reasons, then those without complete data."""
    excluded = (LeftOut(p.code, f"excluded: {p.excluded}") for p in data.people if p.excluded)
    return (*excluded, *design.left_out)


def count_statuses(data: StudyData) -> dict[str, int]:
    """Number of participants by status, in the order of the file."""
    return dict(Counter(person.status for person in data.people))


def count_orders(data: StudyData, codes: tuple[str, ...]) -> dict[str, int]:
    """Number of those participants by order of conditions."""
    wanted = set(codes)
    return dict(sorted(Counter(p.order for p in data.people if p.code in wanted).items()))


def label_condition(name: str) -> str:
    """The condition as tables and figures name it."""
    return name.upper() if name in _NAMED else name
