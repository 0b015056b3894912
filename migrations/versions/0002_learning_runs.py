"""Live learning runs, and which policy a study runs; trials may belong to a run."""

from __future__ import annotations

import json

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"
branch_labels = None
depends_on = None

ROW_ID = sa.BigInteger().with_variant(sa.Integer(), "sqlite")
NAME_LETTERS = 120


def upgrade() -> None:
    describe_policies()
    make_tables()
    let_runs_own_trials()


def describe_policies() -> None:
    """Take name and origin out of the documents; until now only shipped ones were stored."""
    with op.batch_alter_table("policies") as batch:
        batch.add_column(sa.Column("name", sa.String(length=120), nullable=True))
        batch.add_column(sa.Column("origin", sa.String(length=10), nullable=True))
        batch.add_column(sa.Column("source", sa.String(length=10), nullable=True))
    policies = sa.table(
        "policies", *map(sa.column, ("sha256", "document", "name", "origin", "source"))
    )
    connection = op.get_bind()
    for sha256, document in connection.execute(
        sa.select(policies.c.sha256, policies.c.document)
    ).all():
        record = json.loads(document)
        connection.execute(
            sa.update(policies)
            .where(policies.c.sha256 == sha256)
            .values(name=record["name"][:NAME_LETTERS], origin=record["origin"], source="shipped")
        )
    with op.batch_alter_table("policies") as batch:
        batch.alter_column("name", existing_type=sa.String(length=120), nullable=False)
        batch.alter_column("origin", existing_type=sa.String(length=10), nullable=False)
        batch.alter_column("source", existing_type=sa.String(length=10), nullable=False)
        batch.create_check_constraint(
            op.f("ck_policies_source"), "source IN ('shipped', 'uploaded', 'run')"
        )
        batch.create_check_constraint(
            op.f("ck_policies_origin"), "origin IN ('initial', 'people', 'simulated')"
        )


def make_tables() -> None:
    op.create_table(
        "policy_activations",
        sa.Column("id", ROW_ID, nullable=False),
        sa.Column("study_id", sa.String(length=40), nullable=False),
        sa.Column("policy_sha256", sa.String(length=64), nullable=False),
        sa.Column("at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("user_name", sa.String(length=64), nullable=False),
        sa.ForeignKeyConstraint(
            ["policy_sha256"],
            ["policies.sha256"],
            name=op.f("fk_policy_activations_policy_sha256"),
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_policy_activations")),
    )
    op.create_index("ix_policy_activations_study", "policy_activations", ["study_id", "id"])
    op.create_table(
        "learning_runs",
        sa.Column("id", sa.String(length=32), nullable=False),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("created_by", sa.String(length=64), nullable=False),
        sa.Column("scale", sa.String(length=40), nullable=False),
        sa.Column("hall", sa.JSON(), nullable=False),
        sa.Column("settings", sa.JSON(), nullable=False),
        sa.Column("seed", sa.BigInteger(), nullable=False),
        sa.Column("worker", sa.String(length=10), nullable=False),
        sa.Column("worker_token_hash", sa.String(length=64), nullable=True),
        sa.Column("status", sa.String(length=10), nullable=False),
        sa.Column("iteration", sa.Integer(), nullable=False),
        sa.Column("pairs", sa.Integer(), nullable=False),
        sa.Column("ended_at", sa.DateTime(timezone=True), nullable=True),
        sa.CheckConstraint(
            "worker IN ('person', 'simulated')", name=op.f("ck_learning_runs_worker")
        ),
        sa.CheckConstraint(
            "status IN ('open', 'finished', 'stopped')", name=op.f("ck_learning_runs_status")
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_learning_runs")),
        sa.UniqueConstraint("worker_token_hash", name=op.f("uq_learning_runs_worker_token_hash")),
    )
    op.create_index("ix_learning_runs_created_at", "learning_runs", ["created_at"])
    of_run = {"length": 32}
    op.create_table(
        "learning_pairs",
        sa.Column("run_id", sa.String(**of_run), nullable=False),
        sa.Column("number", sa.Integer(), nullable=False),
        sa.Column("iteration", sa.Integer(), nullable=False),
        sa.Column("trial", sa.Integer(), nullable=False),
        sa.Column("trial_seed", sa.BigInteger(), nullable=False),
        *(
            sa.Column(name, sa.Integer(), nullable=False)
            for name in (
                "tick", "domain", "agent", "state", "box", "proposal", "drawn", "label",
                "edit_ticks", "by_expert",
            )
        ),
        sa.ForeignKeyConstraint(
            ["run_id"], ["learning_runs.id"], name=op.f("fk_learning_pairs_run_id")
        ),
        sa.PrimaryKeyConstraint("run_id", "number", name=op.f("pk_learning_pairs")),
    )  # fmt: skip
    op.create_table(
        "learning_versions",
        sa.Column("run_id", sa.String(**of_run), nullable=False),
        sa.Column("iteration", sa.Integer(), nullable=False),
        sa.Column("policy_sha256", sa.String(length=64), nullable=False),
        sa.ForeignKeyConstraint(
            ["run_id"], ["learning_runs.id"], name=op.f("fk_learning_versions_run_id")
        ),
        sa.ForeignKeyConstraint(
            ["policy_sha256"], ["policies.sha256"], name=op.f("fk_learning_versions_policy_sha256")
        ),
        sa.PrimaryKeyConstraint("run_id", "iteration", name=op.f("pk_learning_versions")),
    )
    op.create_index("ix_learning_versions_policy", "learning_versions", ["policy_sha256"])
    op.create_table(
        "learning_ratings",
        sa.Column("run_id", sa.String(**of_run), nullable=False),
        sa.Column("number", sa.Integer(), nullable=False),
        sa.Column("trial", sa.Integer(), nullable=False),
        sa.Column("tick", sa.Integer(), nullable=False),
        sa.Column("expert", sa.String(length=64), nullable=False),
        sa.Column("agent", sa.Integer(), nullable=False),
        sa.Column("mask", sa.Integer(), nullable=False),
        sa.Column("lead_mask", sa.Integer(), nullable=False),
        sa.Column("drawn", sa.Integer(), nullable=False),
        sa.ForeignKeyConstraint(
            ["run_id"], ["learning_runs.id"], name=op.f("fk_learning_ratings_run_id")
        ),
        sa.PrimaryKeyConstraint("run_id", "number", name=op.f("pk_learning_ratings")),
    )


def let_runs_own_trials() -> None:
    """A trial has exactly one owner: a participant or a run.

    SQLite rebuilds the table; its checks are not read back from there, so they are named anew.
    """
    kept = sa.CheckConstraint(
        "status IN ('open', 'completed', 'timed_out', 'abandoned')", name=op.f("ck_trials_status")
    )
    rebuilt = op.get_bind().dialect.name == "sqlite"
    with op.batch_alter_table("trials", table_args=(kept,) if rebuilt else ()) as batch:
        if not rebuilt:
            batch.drop_constraint(op.f("ck_trials_kind"), type_="check")
        batch.alter_column("participant_id", existing_type=ROW_ID, nullable=True)
        batch.add_column(sa.Column("learning_run_id", sa.String(length=32), nullable=True))
        batch.create_foreign_key(
            op.f("fk_trials_learning_run_id"), "learning_runs", ["learning_run_id"], ["id"]
        )
        batch.create_unique_constraint(
            op.f("uq_trials_learning_run_id_attempt"), ["learning_run_id", "attempt"]
        )
        batch.create_check_constraint(
            op.f("ck_trials_kind"), "kind IN ('practice', 'trial', 'learning')"
        )
        batch.create_check_constraint(
            op.f("ck_trials_owner"), "(participant_id IS NULL) <> (learning_run_id IS NULL)"
        )
        batch.create_index(op.f("ix_trials_policy_sha256"), ["policy_sha256"])
