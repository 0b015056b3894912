"""The tidy tables of an export: their columns, units and meaning.

Columns are fixed here, never taken from what was seen. Every row of every table carries
`study_id, config_hash, mode, is_bot`. The wide table's columns follow from the study: see
`study.records.wide`.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from study.records.cells import (
    Column,
    Table,
    Value,
    format_cell,
    format_row,
    neutralise_formula,
    row_formatter,
)
from study.records.columns import (
    BOT,
    CODE,
    CONDITION,
    HASH,
    MODE,
    ORIGIN,
    POSITION,
    ROBOT,
    STUDY,
    TRIAL,
)
from study.records.observations import EVENTS, EXPERT_LABELS, NOTES, QUALITY

__all__ = (
    "EVENTS",
    "EXPERT_LABELS",
    "LEGS",
    "NOTES",
    "PARTICIPANTS",
    "QUALITY",
    "RESPONSES",
    "ROBOTS",
    "TABLES",
    "TRIALS",
    "Column",
    "Table",
    "Value",
    "format_cell",
    "format_row",
    "neutralise_formula",
    "row_formatter",
)

PARTICIPANTS = Table(
    "participants",
    "one row per participant, those who withdrew included",
    (
        CODE,
        *ORIGIN,
        Column(
            "status",
            "text",
            "joined, active, paused, completed, screened-out, withdrawn, timed-out or excluded",
        ),
        Column("status_reason", "text", "why the status is what it is"),
        Column("flags", "text", "exclusion rules that all trials together break, joined by |"),
        Column("step", "text", "the current step, or the last one reached"),
        Column("condition_order", "text", "conditions in the order met, joined by >"),
        Column("block", "integer", "the set of all orders that the place belongs to, from 0"),
        Column("practice_tries", "integer", "ended tries of the practice"),
        Column("joined_at", "time", "when the landing page was sent"),
        Column("ended_at", "time", "when the participation ended"),
        Column("erased_at", "time", "when everything else of the participant was erased"),
    ),
    key=("participant_code",),
)

TRIALS = Table(
    "trials",
    "one row per trial after the practice",
    (
        TRIAL,
        CODE,
        MODE,
        BOT,
        POSITION,
        CONDITION,
        Column("scale", "text", "the hall"),
        Column("seed", "integer", "seed of the world"),
        HASH,
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
        STUDY,
    ),
    key=("trial_id",),
    refers=(("participant_code", "participants"),),
)

ROBOTS = Table(
    "robots",
    "one row per robot of each ended trial",
    (
        TRIAL,
        ROBOT,
        Column("boxes_delivered", "integer", "boxes unloaded"),
        Column("wait_s", "number", "waiting at stations, added up", "s"),
        Column("completion_s", "number", "when it came home, or the end of the trial", "s"),
        Column("path_m", "number", "length of its way", "m"),
        Column("longest_stall_s", "number", "longest time without progress to its goal", "s"),
        CODE,
        *ORIGIN,
    ),
    key=("trial_id", "robot"),
    refers=(("trial_id", "trials"),),
)

LEGS = Table(
    "legs",
    "one row per leg of a robot's work in each ended trial",
    (
        TRIAL,
        ROBOT,
        Column("leg", "integer", "number of the leg among those of the robot, from 0"),
        Column("state", "text", "what the robot did, e.g. to_shelf or waiting"),
        Column("start_s", "number", "when it began, from the start of the trial", "s"),
        Column("end_s", "number", "when it ended", "s"),
        Column("path_m", "number", "length of its way in this leg", "m"),
        Column("shelf", "integer", "index of the shelf, where there is one"),
        Column("box", "integer", "index of the box, where there is one"),
        Column("station", "integer", "index of the station, 0 to 3, where there is one"),
        Column("ended", "boolean", "false for a leg cut off by the end of the trial"),
        CODE,
        *ORIGIN,
    ),
    key=("trial_id", "robot", "leg"),
    refers=(("trial_id", "trials"),),
)

RESPONSES = Table(
    "responses",
    "one row per answer",
    (
        CODE,
        *ORIGIN,
        Column("step", "text", "the page that asked"),
        POSITION,
        CONDITION,
        Column("instrument", "text", "the group of items; see codebook.csv"),
        Column("item", "text", "the item; see codebook.csv"),
        Column("item_order", "integer", "place of the item on its page, from 1"),
        Column("value", "text", "the stored answer; empty if an optional item was left empty"),
        Column("label", "text", "the answer as it was worded on the page"),
        Column("shown_at", "time", "when the page was first shown"),
        Column("answered_at", "time", "when the page was sent"),
    ),
    key=("participant_code", "step", "item"),
    refers=(("participant_code", "participants"),),
)

TABLES: Mapping[str, Table] = MappingProxyType(
    {
        table.name: table
        for table in (
            PARTICIPANTS,
            TRIALS,
            ROBOTS,
            LEGS,
            RESPONSES,
            EVENTS,
            QUALITY,
            EXPERT_LABELS,
            NOTES,
        )
    }
)
"""Every table of an export but the wide one, in their order there."""
