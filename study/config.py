"""A study as one validated, frozen record with a hash over its canonical JSON.

Its fields are the keys of a study file. Every data row carries the hash of the version that its
participant joined.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from functools import cached_property
from typing import Annotated, Any, Literal, Self

from pydantic import (
    BeforeValidator,
    Field,
    PrivateAttr,
    ValidationInfo,
    WrapValidator,
    model_validator,
)
from pydantic_core import PydanticCustomError
from pydantic_core.core_schema import ValidatorFunctionWrapHandler

from study.ar.thresholds import Thresholds
from study.errors import PolicyError
from study.protocol.consistency import find_problems
from study.protocol.displays import ConditionName
from study.protocol.exclusions import ExclusionRule
from study.protocol.flow import OPTIONAL, Outcome, Plan
from study.protocol.halls import Hall
from study.protocol.items import Item
from study.protocol.orders import all_orders, latin_square
from study.protocol.panel import Ending, Panel
from study.protocol.questionnaires import Instrument, Questionnaire
from study.protocol.records import Record, refuse
from study.protocol.texts import StudyTexts
from study.warehouse.halls import PRESETS, HallSpec

FORMAT = 2
"""Of the canonical JSON; `study.files.earlier` reads what was stored in earlier ones."""
Recruiting = Literal["live", "pilot"]
Seconds = Annotated[float, Field(ge=10.0, le=604_800.0)]


def _as_tuple(value: Any) -> Any:
    return (
        (value,) if isinstance(value, str) else tuple(value) if isinstance(value, list) else value
    )


def _read_thresholds(value: Any, read: ValidatorFunctionWrapHandler) -> Thresholds:
    """Borders out of order are reported like any other wrong value."""
    try:
        thresholds: Thresholds = read(value)
    except PolicyError as error:
        key = error.where.removeprefix("thresholds").lstrip(".")
        raise PydanticCustomError(
            "refused_below", "{reason}", {"reason": error.what, "key": key}
        ) from error
    return thresholds


Scales = Annotated[
    tuple[str, ...], BeforeValidator(_as_tuple, json_schema_input_type=str | tuple[str, ...])
]
Conditions = tuple[ConditionName, ...]


class TrialPlan(Record):
    """The practice: where it is held, what is shown, and how often it may be tried."""

    scale: str = "practice"
    condition: ConditionName = "none"
    tries: Annotated[int, Field(ge=1, le=20)] = 3


class OrderPlan(Record):
    """Which orders of the conditions there are: all, a balanced Latin square, or these rows."""

    kind: Literal["all", "latin-square", "fixed"] = "all"
    rows: tuple[Conditions, ...] = ()


class DisplaySettings(Record):
    """How elements are drawn where the paper leaves it open."""

    ribbon_widest_at: Literal["goal", "robot"] = "goal"


class Limits(Record):
    """How long things may take.

    `trial_s`: longest trial in place of its hall's; `abandon_after_s`: an open trial to which
    nobody came back; `idle_after_s`: a participant of whom nothing was heard on any page.
    """

    trial_s: Annotated[float, Field(ge=10.0, le=36_000.0)] | None = None
    abandon_after_s: Seconds = 3600.0
    idle_after_s: Seconds = 3600.0
    on_disconnect: Literal["pause", "continue"] = "pause"
    time_scale: Annotated[float, Field(ge=1.0, le=4.0)] = 4.0


class Study(Record):
    """Everything that makes two participations comparable."""

    format: Literal[2] = 2
    study_id: Annotated[str, Field(pattern=r"^[a-z][a-z0-9-]{0,39}$")]
    title: Annotated[str, Field(min_length=1, max_length=120)]
    recruiting: Recruiting
    planned_participants: Annotated[int, Field(ge=1, le=100_000)] | None = None
    seed: Annotated[int, Field(ge=0, lt=2**53)]
    conditions: Annotated[Conditions, Field(min_length=1, max_length=5)]
    order: OrderPlan = OrderPlan()
    scale: Scales = ("study",)
    hall: tuple[Hall, ...] = ()
    practice: TrialPlan = TrialPlan()
    policy: Annotated[str, Field(max_length=500)] = ""
    policy_sha256: Annotated[str, Field(pattern=r"^([0-9a-f]{64})?$")] = ""
    thresholds: Annotated[Thresholds, WrapValidator(_read_thresholds)] = Thresholds()
    display: DisplaySettings = DisplaySettings()
    limits: Limits = Limits()
    consent: Instrument
    demographics: Instrument
    questionnaire: tuple[Questionnaire, ...] = ()
    comments: Instrument
    exclusion: tuple[ExclusionRule, ...] = ()
    panel: Panel = Panel()
    endings: Mapping[Outcome, Ending]
    texts: StudyTexts

    _stored_hash: str = PrivateAttr("")

    @model_validator(mode="after")
    def _check_whole(self, info: ValidationInfo) -> Self:
        refuse(find_problems(self, (info.context or {}).get("unsound", ())))
        return self

    @cached_property
    def plan(self) -> Plan:
        """What the state machine needs to know."""
        left_out = {kind for kind in OPTIONAL if not self.items_asked(kind)}
        return Plan(len(self.conditions), self.practice.tries, frozenset(left_out))

    @cached_property
    def orders(self) -> tuple[tuple[str, ...], ...]:
        """The orders of the design; a participant's order is an index into these."""
        if self.order.kind == "fixed":
            return self.order.rows
        make = latin_square if self.order.kind == "latin-square" else all_orders
        return make(self.conditions)

    @cached_property
    def canonical_json(self) -> str:
        """The study as JSON with sorted keys and no spare spaces: one text per meaning."""
        return json.dumps(
            self.model_dump(mode="json"), sort_keys=True, separators=(",", ":"), ensure_ascii=False
        )

    @property
    def config_hash(self) -> str:
        """SHA-256 of the canonical JSON, in hex; of a stored version the hash it is stored by."""
        return self._stored_hash or self._own_hash

    @cached_property
    def _own_hash(self) -> str:
        return hashlib.sha256(self.canonical_json.encode()).hexdigest()

    @property
    def completion_codes(self) -> dict[Outcome, str]:
        """The code of each outcome."""
        return {outcome: ending.code for outcome, ending in self.endings.items()}

    @property
    def all_instruments(self) -> tuple[Instrument, ...]:
        """Every instrument in the order of the pages."""
        steps = ("consent", "demographics", "questionnaire", "final", "comments")
        return tuple(one for step in steps for one in self.instruments(step))

    def instruments(self, step_kind: str) -> tuple[Instrument, ...]:
        """The instruments that a kind of step shows, none if it records nothing of its own."""
        if step_kind in ("questionnaire", "final"):
            place = "end" if step_kind == "final" else "each-trial"
            return tuple(one for one in self.questionnaire if one.place == place)
        single = {"demographics": self.demographics, "comments": self.comments}
        one = single.get(step_kind, self.consent if step_kind == "consent" else None)
        return () if one is None else (one,)

    def items_asked(self, step_kind: str) -> tuple[tuple[Instrument, Item], ...]:
        """Every item that a kind of step asks, with its instrument."""
        return tuple((one, item) for one in self.instruments(step_kind) for item in one.items)

    def scale_at(self, position: int) -> str:
        """The hall of the trial at a position (1-based)."""
        return self.scale[position - 1] if len(self.scale) > 1 else self.scale[0]

    def hall_spec(self, scale: str) -> HallSpec:
        """The parameters of a hall by name: one of the study's own or of the software's."""
        own = {hall.name: hall for hall in self.hall}
        return own[scale].spec if scale in own else PRESETS[scale]

    def revised(self, **changes: Any) -> Study:
        """A validated copy with some fields changed."""
        return Study.model_validate(self.model_dump() | changes)

    def stored_as(self, config_hash: str) -> Study:
        """The same study as a version that is stored by this hash."""
        version = self.model_copy()
        version._stored_hash = config_hash
        return version
