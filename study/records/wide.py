"""The wide table: one row per participant, one column per question and per condition.

Its columns follow from the versions of the study in the export, in the order of their pages, and
never from the answers seen.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from study.records.cells import Column, Kind, Table
from study.records.codebook import ItemEntry
from study.records.columns import CODE, ORIGIN
from study.records.tables import PARTICIPANTS, TRIALS

TRIAL_COLUMNS = (
    "trial_id",
    "position",
    "status",
    "duration_s",
    "sum_wait_s",
    "sum_completion_s",
    "slowest_robot_s",
    "human_path_m",
    "human_still_s",
    "blocked_by_human_s",
)
"""Columns of trials.csv that stand once per condition."""
PERSON_COLUMNS = ("status", "flags", "condition_order")


def wide_table(items: Iterable[ItemEntry], conditions: Sequence[str]) -> Table:
    """The wide table of versions that ask these items and hold these conditions.

    `instrument_item` for what is asked once, `instrument_item_condition` for what is asked after
    each trial, `measure_condition` for what was measured.
    """
    entries = list(items)
    columns: dict[str, Column] = {}
    for entry in entries:
        if not entry.repeated:
            _enter(columns, _item_column(entry))
    measured = {column.name: column for column in TRIALS.columns}
    for condition in conditions:
        for name in TRIAL_COLUMNS:
            source = measured[name]
            meaning = f"{source.meaning}; in the condition {condition}"
            _enter(columns, Column(f"{name}_{condition}", source.kind, meaning, source.unit))
        for entry in entries:
            if entry.repeated:
                _enter(columns, _item_column(entry, condition))
    person = {column.name: column for column in PARTICIPANTS.columns}
    fixed = (CODE, *ORIGIN, *(person[name] for name in PERSON_COLUMNS))
    return Table(
        "wide",
        "one row per participant, one column per question and per condition",
        (*fixed, *columns.values()),
        key=("participant_code",),
        refers=(("participant_code", "participants"),),
    )


def wide_row(
    table: Table,
    person: Mapping[str, Any],
    trials: Iterable[Mapping[str, Any]],
    answers: Iterable[Mapping[str, Any]],
) -> dict[str, Any]:
    """One participant's row from the rows of the long tables; what was not met is None."""
    row: dict[str, Any] = dict.fromkeys(table.header)
    row |= {name: person[name] for name in row if name in person}
    for trial in trials:
        row |= {f"{name}_{trial['condition']}": trial[name] for name in TRIAL_COLUMNS}
    for answer in answers:
        name = f"{answer['instrument']}_{answer['item']}"
        if answer["condition"] is not None:
            name = f"{name}_{answer['condition']}"
        row[name] = answer["value"] or None
    return row


def _item_column(entry: ItemEntry, condition: str = "") -> Column:
    name, meaning = f"{entry.instrument}_{entry.item}", entry.wording
    if condition:
        name, meaning = f"{name}_{condition}", f"{meaning} (in the condition {condition})"
    kind: Kind = "integer" if entry.whole else "text"
    return Column(name, kind, meaning, entry.unit)


def _enter(columns: dict[str, Column], column: Column) -> None:
    """Keep the first of several versions; where their kinds differ, text holds them all."""
    known = columns.setdefault(column.name, column)
    if known.kind != column.kind:
        columns[column.name] = Column(known.name, "text", known.meaning, known.unit)
