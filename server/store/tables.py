"""The tables of a study. Migrations under `migrations/versions/` make them; a test holds the two
equal.

Those of learning runs and of policies stand in `server.store.learning_tables`, what trials are
measured by in `server.store.measure_tables`; whoever imports this module has them all.
"""

from __future__ import annotations

from datetime import datetime
from typing import Any

from sqlalchemy import (
    BigInteger,
    CheckConstraint,
    ForeignKey,
    Index,
    String,
    Text,
    UniqueConstraint,
)
from sqlalchemy.orm import Mapped, mapped_column

from server.store.base import Base, RowId
from server.store.learning_tables import (
    LearningPair,
    LearningRating,
    LearningRun,
    LearningVersion,
    PolicyActivation,
    StoredPolicy,
)
from server.store.measure_tables import TrialLeg, TrialQuality, TrialRobot

__all__ = (
    "AuditEntry",
    "Base",
    "Claim",
    "LearningPair",
    "LearningRating",
    "LearningRun",
    "LearningVersion",
    "PanelId",
    "Participant",
    "ParticipantChange",
    "PolicyActivation",
    "Response",
    "StaffNote",
    "StoredPolicy",
    "StudyVersion",
    "Trial",
    "TrialChunk",
    "TrialEvent",
    "TrialLeg",
    "TrialQuality",
    "TrialRobot",
    "User",
)

STATUS_RULE = (
    "status IN ('joined', 'active', 'paused', 'completed', 'screened-out', 'withdrawn', "
    "'timed-out', 'excluded')"
)


class StudyVersion(Base):
    """One version of a study, frozen: its canonical JSON and hash."""

    __tablename__ = "study_versions"
    id: Mapped[int] = mapped_column(RowId, primary_key=True)
    study_id: Mapped[str] = mapped_column(String(40), index=True)
    config_hash: Mapped[str] = mapped_column(String(64), unique=True)
    config_json: Mapped[str] = mapped_column(Text)
    added_at: Mapped[datetime]


class Participant(Base):
    """One participation. The token is stored hashed; panel ids live in a table of their own.

    `status_before` is what an excluded one was before. Of an erased one this row stays as a
    tombstone: its code, where it stood, and when. Before `grace_until`, which staff can set, nobody
    is timed out.
    """

    __tablename__ = "participants"
    __table_args__ = (
        CheckConstraint("mode IN ('live', 'pilot', 'bot')", name="mode"),
        CheckConstraint(STATUS_RULE, name="status"),
        Index("ix_participants_study_mode", "study_id", "mode"),
    )
    id: Mapped[int] = mapped_column(RowId, primary_key=True)
    code: Mapped[str] = mapped_column(String(20), unique=True)
    token_hash: Mapped[str] = mapped_column(String(64), unique=True)
    study_version_id: Mapped[int] = mapped_column(ForeignKey("study_versions.id"))
    study_id: Mapped[str] = mapped_column(String(40))
    mode: Mapped[str] = mapped_column(String(10))
    is_bot: Mapped[bool]
    step: Mapped[str] = mapped_column(String(40))
    practice_tries: Mapped[int]
    status: Mapped[str] = mapped_column(String(20))
    status_before: Mapped[str | None] = mapped_column(String(20))
    block: Mapped[int | None]
    order_index: Mapped[int | None]
    joined_at: Mapped[datetime]
    seen_at: Mapped[datetime]
    step_shown_at: Mapped[datetime | None]
    ended_at: Mapped[datetime | None]
    erased_at: Mapped[datetime | None]
    grace_until: Mapped[datetime | None]


class ParticipantChange(Base):
    """One change of a participation's status, with its reason; rows are added, never changed.

    `actor` is `participant`, `server` or the name of a staff account.
    """

    __tablename__ = "participant_changes"
    __table_args__ = (Index("ix_participant_changes_participant_id", "participant_id"),)
    id: Mapped[int] = mapped_column(RowId, primary_key=True)
    participant_id: Mapped[int] = mapped_column(ForeignKey("participants.id"))
    at: Mapped[datetime]
    from_status: Mapped[str | None] = mapped_column(String(20))
    to_status: Mapped[str] = mapped_column(String(20))
    reason: Mapped[str] = mapped_column(String(200))
    actor: Mapped[str] = mapped_column(String(64))


class PanelId(Base):
    """What a recruitment panel calls a participant; apart from all research data."""

    __tablename__ = "panel_ids"
    participant_id: Mapped[int] = mapped_column(ForeignKey("participants.id"), primary_key=True)
    name: Mapped[str] = mapped_column(String(40), primary_key=True)
    value: Mapped[str] = mapped_column(String(200))


class Claim(Base):
    """The ledger of places in the design: rows are added, never changed."""

    __tablename__ = "claims"
    __table_args__ = (
        CheckConstraint("kind IN ('claimed', 'completed', 'released')", name="kind"),
        Index("ix_claims_study_mode", "study_id", "mode"),
        Index("ix_claims_participant_id", "participant_id"),
    )
    id: Mapped[int] = mapped_column(RowId, primary_key=True)
    study_id: Mapped[str] = mapped_column(String(40))
    mode: Mapped[str] = mapped_column(String(10))
    participant_id: Mapped[int] = mapped_column(ForeignKey("participants.id"))
    block: Mapped[int]
    order_index: Mapped[int]
    kind: Mapped[str] = mapped_column(String(10))
    reason: Mapped[str] = mapped_column(String(40))
    at: Mapped[datetime]


class StaffNote(Base):
    """What a member of staff wrote about a participant, or about a moment of one of their trials.

    `tick` is the moment of the trial `trial_id`; both are None for a note about the participant.
    """

    __tablename__ = "staff_notes"
    __table_args__ = (Index("ix_staff_notes_participant_id", "participant_id"),)
    id: Mapped[int] = mapped_column(RowId, primary_key=True)
    participant_id: Mapped[int] = mapped_column(ForeignKey("participants.id"))
    trial_id: Mapped[str | None] = mapped_column(ForeignKey("trials.id"))
    tick: Mapped[int | None]
    at: Mapped[datetime]
    user_name: Mapped[str] = mapped_column(String(64))
    text: Mapped[str] = mapped_column(String(500))


class Response(Base):
    """One stored answer; never two for the same participant, step and item."""

    __tablename__ = "responses"
    __table_args__ = (UniqueConstraint("participant_id", "step", "item"),)
    id: Mapped[int] = mapped_column(RowId, primary_key=True)
    participant_id: Mapped[int] = mapped_column(ForeignKey("participants.id"))
    step: Mapped[str] = mapped_column(String(40))
    item: Mapped[str] = mapped_column(String(40))
    item_order: Mapped[int]
    value: Mapped[str] = mapped_column(Text)
    shown_at: Mapped[datetime | None]
    answered_at: Mapped[datetime]


class Trial(Base):
    """One trial of a participant or of a learning run, with its full configuration and, once it
    ended, its measures.

    In a learning run `attempt` counts the run's trials from 1.
    """

    __tablename__ = "trials"
    __table_args__ = (
        UniqueConstraint("participant_id", "step", "attempt"),
        UniqueConstraint("learning_run_id", "attempt"),
        CheckConstraint("status IN ('open', 'completed', 'timed_out', 'abandoned')", name="status"),
        CheckConstraint("kind IN ('practice', 'trial', 'learning')", name="kind"),
        CheckConstraint("(participant_id IS NULL) <> (learning_run_id IS NULL)", name="owner"),
    )
    id: Mapped[str] = mapped_column(String(32), primary_key=True)
    participant_id: Mapped[int | None] = mapped_column(ForeignKey("participants.id"))
    learning_run_id: Mapped[str | None] = mapped_column(ForeignKey("learning_runs.id"))
    step: Mapped[str] = mapped_column(String(40))
    attempt: Mapped[int]
    kind: Mapped[str] = mapped_column(String(10))
    position: Mapped[int | None]
    condition: Mapped[str] = mapped_column(String(40))
    label: Mapped[str] = mapped_column(String(40))
    scale: Mapped[str] = mapped_column(String(40))
    seed: Mapped[int] = mapped_column(BigInteger)
    config_hash: Mapped[str] = mapped_column(String(64))
    config: Mapped[dict[str, Any]]
    policy_sha256: Mapped[str | None] = mapped_column(ForeignKey("policies.sha256"), index=True)
    status: Mapped[str] = mapped_column(String(20))
    phase: Mapped[str] = mapped_column(String(20))
    ticks: Mapped[int]
    state_hash: Mapped[bytes | None]
    opened_at: Mapped[datetime]
    ended_at: Mapped[datetime | None]
    duration_s: Mapped[float | None]
    sum_wait_s: Mapped[float | None]
    sum_completion_s: Mapped[float | None]
    slowest_robot_s: Mapped[float | None]
    human_path_m: Mapped[float | None]
    human_still_s: Mapped[float | None]
    blocked_by_human_s: Mapped[float | None]
    boxes_delivered: Mapped[int | None]
    longest_stall_s: Mapped[float | None]
    overlaps: Mapped[int | None]


class TrialEvent(Base):
    """One event of a trial; `number` counts from 0 within the trial."""

    __tablename__ = "trial_events"
    trial_id: Mapped[str] = mapped_column(ForeignKey("trials.id"), primary_key=True)
    number: Mapped[int] = mapped_column(primary_key=True)
    tick: Mapped[int]
    kind: Mapped[str] = mapped_column(String(40))
    at: Mapped[datetime]
    data: Mapped[dict[str, Any]]


class TrialChunk(Base):
    """About a second of the journal: the inputs consumed by each tick, and state hashes.

    `hashes` is a sequence of 12-byte records: tick (u32, little endian) and 8 bytes of hash.
    """

    __tablename__ = "trial_chunks"
    trial_id: Mapped[str] = mapped_column(ForeignKey("trials.id"), primary_key=True)
    first_tick: Mapped[int] = mapped_column(primary_key=True)
    ticks: Mapped[int]
    last_seq: Mapped[int] = mapped_column(BigInteger)
    inputs: Mapped[bytes]
    hashes: Mapped[bytes]


class User(Base):
    """A staff account."""

    __tablename__ = "users"
    __table_args__ = (CheckConstraint("role IN ('admin', 'expert')", name="role"),)
    id: Mapped[int] = mapped_column(RowId, primary_key=True)
    name: Mapped[str] = mapped_column(String(64), unique=True)
    role: Mapped[str] = mapped_column(String(10))
    password_hash: Mapped[str] = mapped_column(String(255))
    session_key: Mapped[str] = mapped_column(String(32))
    added_at: Mapped[datetime]


class AuditEntry(Base):
    """What a member of staff did; rows are added, never changed."""

    __tablename__ = "audit"
    id: Mapped[int] = mapped_column(RowId, primary_key=True)
    at: Mapped[datetime]
    user_name: Mapped[str] = mapped_column(String(64))
    action: Mapped[str] = mapped_column(String(40))
    detail: Mapped[str] = mapped_column(String(200))
