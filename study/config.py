"""A study as one validated, frozen record with a hash over its canonical JSON.

Every data row carries the hash of the version that its participant joined.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from functools import cached_property
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from study.ar.thresholds import Thresholds
from study.protocol import demo_items
from study.protocol.demo_texts import TEXTS
from study.protocol.displays import SHOWN, ConditionName
from study.protocol.flow import Outcome, Plan
from study.protocol.orders import all_orders
from study.protocol.questionnaires import Instrument, Record
from study.protocol.texts import StudyTexts

ScaleName = Literal["practice", "small", "study", "large", "lab"]
Recruiting = Literal["live", "pilot"]


class TrialPlan(Record):
    """The practice: where it is held, what is shown, and how often it may be tried."""

    scale: ScaleName = "practice"
    condition: ConditionName = "none"
    tries: Annotated[int, Field(ge=1, le=20)] = 3


class Study(Record):
    """Everything that makes two participations comparable."""

    study_id: Annotated[str, Field(pattern=r"^[a-z][a-z0-9-]{0,39}$")]
    title: Annotated[str, Field(min_length=1, max_length=120)]
    recruiting: Recruiting
    seed: Annotated[int, Field(ge=0, lt=2**53)]
    practice: TrialPlan = TrialPlan()
    scale: ScaleName = "study"
    conditions: Annotated[tuple[ConditionName, ...], Field(min_length=1, max_length=5)]
    consent: Instrument
    demographics: Instrument
    questionnaire: Instrument
    comments: Instrument
    texts: StudyTexts
    completion_codes: Mapping[Outcome, Annotated[str, Field(pattern=r"^[A-Z0-9-]{4,40}$")]]
    panel_fields: tuple[Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]{0,39}$")], ...] = (
        "PROLIFIC_PID",
        "STUDY_ID",
        "SESSION_ID",
    )
    thresholds: Thresholds = Thresholds()
    ribbon_widest_at: Literal["goal", "robot"] = "goal"
    on_disconnect: Literal["pause", "continue"] = "pause"
    abandon_after_s: Annotated[float, Field(gt=0)] = 3600.0
    time_scale_limit: Annotated[float, Field(ge=1.0, le=4.0)] = 4.0

    @model_validator(mode="after")
    def _check_whole(self) -> Self:
        if len(set(self.conditions)) != len(self.conditions):
            raise ValueError("`conditions` must not name a condition twice")
        missing = {"completed", "screened-out", "withdrawn", "timed-out"} - set(
            self.completion_codes
        )
        if missing:
            raise ValueError(f"`completion_codes` lacks {', '.join(sorted(missing))}")
        known = {element.name for element in self.texts.elements}
        unexplained = {name for c in self.conditions for name in SHOWN[c].names} - known
        if unexplained:
            raise ValueError(f"`texts.elements` lacks {', '.join(sorted(unexplained))}")
        return self

    @cached_property
    def plan(self) -> Plan:
        """What the state machine needs to know."""
        return Plan(trials=len(self.conditions), practice_tries=self.practice.tries)

    @cached_property
    def orders(self) -> tuple[tuple[str, ...], ...]:
        """All orders of the conditions; a participant's order is an index into these."""
        return all_orders(self.conditions)

    @cached_property
    def canonical_json(self) -> str:
        """The study as JSON with sorted keys and no spare spaces: one text per meaning."""
        return json.dumps(
            self.model_dump(mode="json"), sort_keys=True, separators=(",", ":"), ensure_ascii=False
        )

    @cached_property
    def config_hash(self) -> str:
        """SHA-256 of the canonical JSON, in hex."""
        return hashlib.sha256(self.canonical_json.encode()).hexdigest()

    def revised(self, **changes: Any) -> Study:
        """A validated copy with some fields changed."""
        return Study.model_validate(self.model_dump() | changes)

    def instrument(self, step_kind: str) -> Instrument | None:
        """The items of a kind of step, or None if it records none of its own."""
        instruments = {
            "consent": self.consent,
            "demographics": self.demographics,
            "questionnaire": self.questionnaire,
            "comments": self.comments,
        }
        return instruments.get(step_kind)


def paper_study() -> Study:
    """The demo study `demo`: the paper's three conditions and questionnaire in our wording.

    It recruits pilots: a demonstration must never end up among live data.
    """
    return Study(
        study_id="demo",
        title="Working with a team of robots",
        recruiting="pilot",
        seed=20221214,
        conditions=("varil", "arroch", "crmiar"),
        consent=demo_items.CONSENT,
        demographics=demo_items.DEMOGRAPHICS,
        questionnaire=demo_items.QUESTIONNAIRE,
        comments=demo_items.COMMENTS,
        texts=TEXTS,
        completion_codes={
            "completed": "ROBOTS-7K2M",
            "screened-out": "ROBOTS-3TRY",
            "withdrawn": "ROBOTS-WDRN",
            "timed-out": "ROBOTS-TIME",
        },
    )
