"""Tables of policies and of live learning runs."""

from __future__ import annotations

from datetime import datetime
from typing import Any

from sqlalchemy import BigInteger, CheckConstraint, ForeignKey, Index, String, Text
from sqlalchemy.orm import Mapped, mapped_column

from server.store.base import Base, RowId


class StoredPolicy(Base):
    """A policy by its hash: its file's text, and from it what lists show.

    `source` says how it came here first: with the software, from an upload, or from a learning
    run.
    """

    __tablename__ = "policies"
    __table_args__ = (
        CheckConstraint("source IN ('shipped', 'uploaded', 'run')", name="source"),
        CheckConstraint("origin IN ('initial', 'people', 'simulated')", name="origin"),
    )
    sha256: Mapped[str] = mapped_column(String(64), primary_key=True)
    document: Mapped[str] = mapped_column(Text)
    added_at: Mapped[datetime]
    name: Mapped[str] = mapped_column(String(120))
    origin: Mapped[str] = mapped_column(String(10))
    source: Mapped[str] = mapped_column(String(10))


class PolicyActivation(Base):
    """Which policy a study's trials run from a moment on; rows are added, the newest counts."""

    __tablename__ = "policy_activations"
    __table_args__ = (Index("ix_policy_activations_study", "study_id", "id"),)
    id: Mapped[int] = mapped_column(RowId, primary_key=True)
    study_id: Mapped[str] = mapped_column(String(40))
    policy_sha256: Mapped[str] = mapped_column(ForeignKey("policies.sha256"))
    at: Mapped[datetime]
    user_name: Mapped[str] = mapped_column(String(64))


class LearningRun(Base):
    """One run of PolicyUp with people. `hall` and `settings` are fixed when it is started.

    `iteration` and `pairs` are how far what is stored has come. A worker's token is stored hashed.
    """

    __tablename__ = "learning_runs"
    __table_args__ = (
        CheckConstraint("worker IN ('person', 'simulated')", name="worker"),
        CheckConstraint("status IN ('open', 'finished', 'stopped')", name="status"),
        Index("ix_learning_runs_created_at", "created_at"),
    )
    id: Mapped[str] = mapped_column(String(32), primary_key=True)
    created_at: Mapped[datetime]
    created_by: Mapped[str] = mapped_column(String(64))
    scale: Mapped[str] = mapped_column(String(40))
    hall: Mapped[dict[str, Any]]
    settings: Mapped[dict[str, Any]]
    seed: Mapped[int] = mapped_column(BigInteger)
    worker: Mapped[str] = mapped_column(String(10))
    worker_token_hash: Mapped[str | None] = mapped_column(String(64), unique=True)
    status: Mapped[str] = mapped_column(String(10))
    iteration: Mapped[int]
    pairs: Mapped[int]
    ended_at: Mapped[datetime | None]


class LearningPair(Base):
    """One pair of the dataset; the fields of `study.learning.dataset.Pair`."""

    __tablename__ = "learning_pairs"
    run_id: Mapped[str] = mapped_column(ForeignKey("learning_runs.id"), primary_key=True)
    number: Mapped[int] = mapped_column(primary_key=True)
    iteration: Mapped[int]
    trial: Mapped[int]
    trial_seed: Mapped[int] = mapped_column(BigInteger)
    tick: Mapped[int]
    domain: Mapped[int]
    agent: Mapped[int]
    state: Mapped[int]
    box: Mapped[int]
    proposal: Mapped[int]
    drawn: Mapped[int]
    label: Mapped[int]
    edit_ticks: Mapped[int]
    by_expert: Mapped[int]


class LearningVersion(Base):
    """The policy of a run after so many iterations; 0 is the one it began with."""

    __tablename__ = "learning_versions"
    __table_args__ = (Index("ix_learning_versions_policy", "policy_sha256"),)
    run_id: Mapped[str] = mapped_column(ForeignKey("learning_runs.id"), primary_key=True)
    iteration: Mapped[int] = mapped_column(primary_key=True)
    policy_sha256: Mapped[str] = mapped_column(ForeignKey("policies.sha256"))


class LearningRating(Base):
    """What an expert who does not lead had set for an agent at a snapshot; for agreement only."""

    __tablename__ = "learning_ratings"
    run_id: Mapped[str] = mapped_column(ForeignKey("learning_runs.id"), primary_key=True)
    number: Mapped[int] = mapped_column(primary_key=True)
    trial: Mapped[int]
    tick: Mapped[int]
    expert: Mapped[str] = mapped_column(String(64))
    agent: Mapped[int]
    mask: Mapped[int]
    lead_mask: Mapped[int]
    drawn: Mapped[int]
