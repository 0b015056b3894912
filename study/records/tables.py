"""The tidy tables of an export: their columns, and how a value becomes a cell.

Columns are fixed here, never taken from what was seen. Every row of every table carries
`study_id, config_hash, mode, is_bot`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from types import MappingProxyType
from typing import Literal

Kind = Literal["text", "integer", "number", "boolean", "time"]
Value = str | int | float | bool | datetime | None

_FORMULA_STARTS = frozenset("=+-@\t\r\n＝＋－＠")


@dataclass(frozen=True)
class Column:
    """One column: its type, unit ("" = none) and meaning."""

    name: str
    kind: Kind
    meaning: str
    unit: str = ""


@dataclass(frozen=True)
class Table:
    """One file of the export."""

    name: str
    meaning: str
    columns: tuple[Column, ...]

    @property
    def file(self) -> str:
        """Its name in the zip."""
        return f"{self.name}.csv"

    @property
    def header(self) -> list[str]:
        """The names of its columns."""
        return [column.name for column in self.columns]


_STUDY = Column("study_id", "text", "the study")
_HASH = Column("config_hash", "text", "SHA-256 of the version of the study that was joined")
_MODE = Column("mode", "text", "live, pilot or bot; fixed when joining")
_BOT = Column("is_bot", "boolean", "true for simulated participants")
_CODE = Column("participant_code", "text", "random code of the participant")
_TRIAL = Column("trial_id", "text", "the trial")
_ROBOT = Column("robot", "integer", "index of the robot, from 0")
_POSITION = Column("position", "integer", "1 for the first trial of a participant, and so on")
_CONDITION = Column("condition", "text", "what decided about the display")

PARTICIPANTS = Table(
    "participants",
    "one row per participant, those who withdrew included",
    (
        _CODE,
        _STUDY,
        _HASH,
        _MODE,
        _BOT,
        Column("status", "text", "active, completed, screened-out, withdrawn or timed-out"),
        Column("step", "text", "the current step, or the last one reached"),
        Column("condition_order", "text", "conditions in the order met, joined by >"),
        Column("block", "integer", "the set of all orders that the place belongs to, from 0"),
        Column("practice_tries", "integer", "ended tries of the practice"),
        Column("joined_at", "time", "when the landing page was sent"),
        Column("ended_at", "time", "when the participation ended"),
    ),
)

TRIALS = Table(
    "trials",
    "one row per trial after the practice",
    (
        _TRIAL,
        _CODE,
        _MODE,
        _BOT,
        _POSITION,
        _CONDITION,
        Column("scale", "text", "the hall"),
        Column("seed", "integer", "seed of the world"),
        _HASH,
        Column(
            "policy_sha256",
            "text",
            "hash of the policy that decided, if one did; README.txt tells its origin",
        ),
        Column("status", "text", "open, completed, timed_out (at its cap) or abandoned"),
        Column("ticks", "integer", "steps of the world of 1/30 s"),
        Column("duration_s", "number", "time until every robot was home", "s"),
        Column("sum_wait_s", "number", "waiting of all robots at the stations, added up", "s"),
        Column("sum_completion_s", "number", "times at which robots came home, added up", "s"),
        Column("slowest_robot_s", "number", "when the last robot came home", "s"),
        Column("human_path_m", "number", "length of the person's way", "m"),
        Column("human_still_s", "number", "time in which the person stood still", "s"),
        Column("blocked_by_human_s", "number", "time in which the person blocked a bay", "s"),
        _STUDY,
    ),
)

ROBOTS = Table(
    "robots",
    "one row per robot of each ended trial",
    (
        _TRIAL,
        _ROBOT,
        Column("boxes_delivered", "integer", "boxes unloaded"),
        Column("wait_s", "number", "waiting at stations, added up", "s"),
        Column("completion_s", "number", "when it came home, or the end of the trial", "s"),
        Column("path_m", "number", "length of its way", "m"),
        Column("longest_stall_s", "number", "longest time without progress to its goal", "s"),
        _CODE,
        _STUDY,
        _HASH,
        _MODE,
        _BOT,
    ),
)

LEGS = Table(
    "legs",
    "one row per leg of a robot's work in each ended trial",
    (
        _TRIAL,
        _ROBOT,
        Column("leg", "integer", "number of the leg among those of the robot, from 0"),
        Column("state", "text", "what the robot did, e.g. to_shelf or waiting"),
        Column("start_s", "number", "when it began, from the start of the trial", "s"),
        Column("end_s", "number", "when it ended", "s"),
        Column("path_m", "number", "length of its way in this leg", "m"),
        Column("shelf", "integer", "index of the shelf, where there is one"),
        Column("box", "integer", "index of the box, where there is one"),
        Column("station", "integer", "index of the station, 0 to 3, where there is one"),
        Column("ended", "boolean", "false for a leg cut off by the end of the trial"),
        _CODE,
        _STUDY,
        _HASH,
        _MODE,
        _BOT,
    ),
)

RESPONSES = Table(
    "responses",
    "one row per answer",
    (
        _CODE,
        _STUDY,
        _HASH,
        _MODE,
        _BOT,
        Column("step", "text", "the page that asked"),
        _POSITION,
        _CONDITION,
        Column("instrument", "text", "the group of items; see codebook.csv"),
        Column("item", "text", "the item; see codebook.csv"),
        Column("item_order", "integer", "place of the item on its page, from 1"),
        Column("value", "text", "the stored answer; empty if an optional item was left empty"),
        Column("label", "text", "the answer as it was worded on the page"),
        Column("shown_at", "time", "when the page was first shown"),
        Column("answered_at", "time", "when the page was sent"),
    ),
)

TABLES: Mapping[str, Table] = MappingProxyType(
    {table.name: table for table in (PARTICIPANTS, TRIALS, ROBOTS, LEGS, RESPONSES)}
)


def format_row(table: Table, row: Mapping[str, Value]) -> list[str]:
    """The row's cells in the table's order; KeyError if a column is missing."""
    return [format_cell(column, row[column.name]) for column in table.columns]


def format_cell(column: Column, value: Value) -> str:
    """A value as text: ISO-8601 UTC, true/false, shortest exact numbers, empty for nothing."""
    if value is None:
        return ""
    if column.kind == "text":
        return neutralise_formula(str(value))
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, datetime):
        return value.astimezone(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
    return repr(value) if isinstance(value, float) else str(value)


def neutralise_formula(text: str) -> str:
    """The text, with an apostrophe before it if a spreadsheet would run it as a formula."""
    return f"'{text}" if text[:1] in _FORMULA_STARTS else text
