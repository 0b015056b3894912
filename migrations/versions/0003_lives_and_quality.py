"""Participations as lives with reasons, tombstones, and the quality of trials."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None

ROW_ID = sa.BigInteger().with_variant(sa.Integer(), "sqlite")
STATUSES = (
    "status IN ('joined', 'active', 'paused', 'completed', 'screened-out', 'withdrawn', "
    "'timed-out', 'excluded')"
)
BEFORE = "noted before reasons were kept"


def upgrade() -> None:
    _make_changes()
    _make_quality()
    op.add_column("participants", sa.Column("status", sa.String(length=20), nullable=True))
    op.execute(
        "UPDATE participants SET status = COALESCE(outcome, "
        "CASE WHEN step = 'consent' THEN 'joined' ELSE 'active' END)"
    )
    _note_what_was()
    _rebuild_participants()
    _free_claims()


def _make_changes() -> None:
    op.create_table(
        "participant_changes",
        sa.Column("id", ROW_ID, nullable=False),
        sa.Column("participant_id", ROW_ID, nullable=False),
        sa.Column("at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("from_status", sa.String(length=20), nullable=True),
        sa.Column("to_status", sa.String(length=20), nullable=False),
        sa.Column("reason", sa.String(length=200), nullable=False),
        sa.Column("actor", sa.String(length=64), nullable=False),
        sa.ForeignKeyConstraint(
            ["participant_id"],
            ["participants.id"],
            name=op.f("fk_participant_changes_participant_id"),
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_participant_changes")),
    )
    op.create_index(
        "ix_participant_changes_participant_id",
        "participant_changes",
        ["participant_id"],
        unique=False,
    )


def _make_quality() -> None:
    op.create_table(
        "trial_quality",
        sa.Column("trial_id", sa.String(length=32), nullable=False),
        sa.Column("rtt_median_ms", sa.Double(), nullable=True),
        sa.Column("rtt_p95_ms", sa.Double(), nullable=True),
        sa.Column("frame_rate_median_hz", sa.Double(), nullable=True),
        sa.Column("frame_rate_p5_hz", sa.Double(), nullable=True),
        sa.Column("long_frames", sa.Integer(), nullable=True),
        sa.Column("longest_frame_ms", sa.Double(), nullable=True),
        sa.Column("hidden_s", sa.Double(), nullable=True),
        sa.Column("unfocused_s", sa.Double(), nullable=True),
        sa.Column("pointer_lock_losses", sa.Integer(), nullable=True),
        sa.Column("pauses", sa.Integer(), nullable=False),
        sa.Column("paused_s", sa.Double(), nullable=False),
        sa.Column("idle_s", sa.Double(), nullable=False),
        sa.Column("tick_late_p99_ms", sa.Double(), nullable=True),
        sa.Column("tick_late_max_ms", sa.Double(), nullable=True),
        sa.Column("connections", sa.Integer(), nullable=False),
        sa.Column("reports", sa.Integer(), nullable=False),
        sa.ForeignKeyConstraint(
            ["trial_id"], ["trials.id"], name=op.f("fk_trial_quality_trial_id")
        ),
        sa.PrimaryKeyConstraint("trial_id", name=op.f("pk_trial_quality")),
    )


def _note_what_was() -> None:
    """What earlier versions knew of each life, as its first entries."""
    fields = "INSERT INTO participant_changes (participant_id, at, from_status, to_status, reason, "
    op.execute(
        f"{fields} actor) SELECT id, joined_at, NULL, 'joined', '{BEFORE}', 'participant' "  # noqa: S608
        "FROM participants ORDER BY id"
    )
    op.execute(
        f"{fields} actor) SELECT id, COALESCE(ended_at, seen_at), 'joined', status, '{BEFORE}', "  # noqa: S608
        "'server' FROM participants WHERE status <> 'joined' ORDER BY id"
    )


def _rebuild_participants() -> None:
    with op.batch_alter_table("participants") as batch:
        batch.drop_constraint(op.f("ck_participants_outcome"), type_="check")
        batch.drop_column("outcome")
        batch.alter_column("status", existing_type=sa.String(length=20), nullable=False)
        batch.add_column(sa.Column("status_before", sa.String(length=20), nullable=True))
        batch.add_column(sa.Column("erased_at", sa.DateTime(timezone=True), nullable=True))
        batch.create_check_constraint(op.f("ck_participants_status"), STATUSES)


def _free_claims() -> None:
    """One who is reinstated takes the place again: no longer one row of each kind."""
    with op.batch_alter_table("claims") as batch:
        batch.drop_constraint(op.f("uq_claims_participant_id_kind"), type_="unique")
    op.create_index("ix_claims_participant_id", "claims", ["participant_id"], unique=False)
