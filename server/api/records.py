"""What `/api/v1` takes and answers, as records that its description is made from."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Any, Generic, Literal, TypeVar

from fastapi import Path, Query
from pydantic import BaseModel, ConfigDict, Field

from server.desks.bots import MOST_AT_ONCE
from study.protocol.lifecycle import Status

Row = TypeVar("Row")
Mode = Literal["live", "pilot", "bot"]
Offset = Annotated[int, Query(ge=0, le=2**31, description="How many rows to pass over.")]
Limit = Annotated[int, Query(ge=1, le=500, description="How many rows to answer at most.")]
PRINTABLE = r"^[^\x00]*$"
Name = Annotated[str, Path(max_length=64, pattern=PRINTABLE)]
Wanted = Annotated[str | None, Query(max_length=40, pattern=PRINTABLE)]
Code = Annotated[str, Field(min_length=1, max_length=40, pattern=PRINTABLE)]


class Answer(BaseModel):
    """A record that is answered."""

    model_config = ConfigDict(frozen=True)


class Page(Answer, Generic[Row]):
    """One page of a list; `total` counts the rows of all pages."""

    total: int
    offset: int
    limit: int
    items: list[Row]


class Problem(Answer):
    """What went wrong, and what to do next."""

    type: str = "about:blank"
    title: str
    status: int
    detail: str
    next_step: str = ""
    reference: str = ""


class StudySummary(Answer):
    """A study that can be joined here."""

    study_id: str
    title: str
    config_hash: str
    recruiting: Literal["live", "pilot"]
    conditions: list[str]
    planned_participants: int | None
    counts: dict[str, dict[str, int]] = Field(description="Participants by mode and status.")


class StudyDetail(StudySummary):
    """A study with its orders and its whole definition."""

    orders: list[list[str]]
    steps: list[str]
    definition: dict[str, Any] = Field(description="The study file's content.")


class Participant(Answer):
    """A participation; neither token nor panel ids are part of it."""

    code: str
    study_id: str
    config_hash: str
    mode: Mode
    is_bot: bool
    status: Status
    step: str
    block: int | None
    order_index: int | None
    practice_tries: int
    joined_at: datetime
    seen_at: datetime
    ended_at: datetime | None
    erased_at: datetime | None


class Change(Answer):
    """One change of a participation's status."""

    at: datetime | None
    was: Status | None
    now: Status
    reason: str
    actor: str


class ParticipantDetail(Participant):
    """A participation with its history."""

    changes: list[Change]


class Trial(Answer):
    """A trial of a participant, practice included; measures are there once it has ended."""

    trial_id: str
    participant_code: str
    study_id: str
    mode: Mode
    is_bot: bool
    step: str
    attempt: int
    kind: Literal["practice", "trial"]
    position: int | None
    condition: str
    scale: str
    seed: int
    config_hash: str
    policy_sha256: str | None
    status: Literal["open", "completed", "timed_out", "abandoned"]
    ticks: int
    opened_at: datetime
    ended_at: datetime | None
    duration_s: float | None
    sum_wait_s: float | None
    sum_completion_s: float | None
    slowest_robot_s: float | None


class Policy(Answer):
    """A stored policy; `trials` counts participants' trials that ran it."""

    sha256: str
    name: str
    origin: str
    source: Literal["shipped", "uploaded", "run"]
    added_at: datetime
    runs: int
    trials: int
    studies: list[str]


class Reason(BaseModel):
    """Why a participant is excluded or reinstated."""

    model_config = ConfigDict(extra="forbid")
    reason: Annotated[str, Field(min_length=1, max_length=200, pattern=PRINTABLE)]


class BotOrder(BaseModel):
    """How many simulated participants are wanted."""

    model_config = ConfigDict(extra="forbid")
    count: Annotated[int, Field(ge=1, le=MOST_AT_ONCE)]


class Bot(Answer):
    """A simulated participant with the personal address, which is told only here."""

    code: str
    address: str


class Bots(Answer):
    """Those who were issued."""

    bots: list[Bot]


class BotCodes(BaseModel):
    """Simulated participants by code."""

    model_config = ConfigDict(extra="forbid")
    codes: Annotated[list[Code], Field(min_length=1, max_length=MOST_AT_ONCE)]


class Ended(Answer):
    """How many participations were ended."""

    ended: int
