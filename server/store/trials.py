"""Trials: opened once per step and attempt, ended once, with everything needed to replay them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import TYPE_CHECKING, Any

from sqlalchemy import ColumnElement, func, select, update
from sqlalchemy.ext.asyncio import AsyncSession

from server.store.tables import Trial, TrialLeg, TrialQuality, TrialRobot
from study.errors import NotFound

if TYPE_CHECKING:
    from server.live.ports import TrialResult


_TRIAL_MEASURES = (
    "duration_s",
    "sum_wait_s",
    "sum_completion_s",
    "slowest_robot_s",
    "human_path_m",
    "human_still_s",
    "blocked_by_human_s",
    "boxes_delivered",
    "longest_stall_s",
    "overlaps",
)
_ROBOT_MEASURES = (
    "robot",
    "boxes_delivered",
    "wait_s",
    "completion_s",
    "path_m",
    "longest_stall_s",
    "blocked_by_human_s",
)
_LEG_FIELDS = ("robot", "leg", "state", "start_s", "end_s", "path_m", "ended")
_LEG_PLACES = ("shelf", "box", "station")


class UnknownTrial(NotFound):
    """No trial has this id."""

    def __init__(self, trial_id: str) -> None:
        self.trial_id = trial_id
        super().__init__(
            f"there is no trial “{trial_id[:40]}”", next_step="Take its id from the export."
        )


@dataclass(frozen=True)
class TrialRecord:
    """A stored trial; `config` holds everything that determines its world besides the inputs.

    It belongs to a participant or to a learning run, whose trials `attempt` counts from 1.
    """

    id: str
    participant_id: int | None
    step: str
    attempt: int
    kind: str
    position: int | None
    condition: str
    label: str
    scale: str
    seed: int
    config_hash: str
    config: Mapping[str, Any]
    policy_sha256: str | None
    status: str = "open"
    ticks: int = 0
    state_hash: bytes | None = None
    learning_run_id: str | None = None


async def find_trial(
    session: AsyncSession, participant_id: int, step: str, attempt: int
) -> TrialRecord | None:
    """The trial of this step and attempt (1-based), if it was opened before."""
    row = await session.scalar(
        select(Trial).where(
            Trial.participant_id == participant_id, Trial.step == step, Trial.attempt == attempt
        )
    )
    return None if row is None else _record(row)


async def read_trial(session: AsyncSession, trial_id: str, *, lock: bool = False) -> TrialRecord:
    """The trial with this id; raises `UnknownTrial`."""
    query = select(Trial).where(Trial.id == trial_id)
    row = await session.scalar(query.with_for_update() if lock else query)
    if row is None:
        raise UnknownTrial(trial_id)
    return _record(row)


async def add_trial(session: AsyncSession, trial: TrialRecord, now: datetime) -> None:
    """Store a trial that is about to be opened."""
    session.add(
        Trial(
            id=trial.id,
            participant_id=trial.participant_id,
            learning_run_id=trial.learning_run_id,
            step=trial.step,
            attempt=trial.attempt,
            kind=trial.kind,
            position=trial.position,
            condition=trial.condition,
            label=trial.label,
            scale=trial.scale,
            seed=trial.seed,
            config_hash=trial.config_hash,
            config=dict(trial.config),
            policy_sha256=trial.policy_sha256,
            status=trial.status,
            phase="waiting",
            ticks=0,
            opened_at=now,
        )
    )
    await session.flush()


async def store_result(session: AsyncSession, trial_id: str, result: TrialResult) -> None:
    """Note how a trial ended: its status, its measures, its robots and their legs."""
    measures = result.measures
    await session.execute(
        update(Trial)
        .where(Trial.id == trial_id)
        .values(
            status=result.status,
            phase="finished",
            ticks=result.ticks,
            state_hash=result.state_hash,
            ended_at=result.ended_at_utc,
            **{name: getattr(measures, name) for name in _TRIAL_MEASURES},
        )
    )
    session.add_all(
        TrialRobot(trial_id=trial_id, **{name: getattr(robot, name) for name in _ROBOT_MEASURES})
        for robot in measures.robots
    )
    session.add_all(
        TrialLeg(
            trial_id=trial_id,
            **{name: getattr(leg, name) for name in _LEG_FIELDS},
            **{name: _or_none(getattr(leg, name)) for name in _LEG_PLACES},
        )
        for leg in measures.legs
    )
    if result.quality is not None:
        session.add(TrialQuality(trial_id=trial_id, **vars(result.quality)))
    await session.flush()


async def list_run_trials(session: AsyncSession, run_id: str) -> list[TrialRecord]:
    """The trials of a learning run, oldest first."""
    rows = await session.scalars(
        select(Trial).where(Trial.learning_run_id == run_id).order_by(Trial.attempt)
    )
    return [_record(row) for row in rows]


async def store_limit(session: AsyncSession, trial: TrialRecord, limit_s: float) -> None:
    """Wait so long for this trial's absent participant, also when it is opened again."""
    config = {**trial.config, "abandon_after_s": limit_s}
    await session.execute(update(Trial).where(Trial.id == trial.id).values(config=config))


async def abandon_open(session: AsyncSession, participant_id: int, now: datetime) -> None:
    """Mark what this participant left unfinished."""
    await _abandon(session, Trial.participant_id == participant_id, now)


async def abandon_run_trials(session: AsyncSession, run_id: str, now: datetime) -> None:
    """Mark what was left unfinished when a learning run ended."""
    await _abandon(session, Trial.learning_run_id == run_id, now)


async def _abandon(session: AsyncSession, mine: ColumnElement[bool], now: datetime) -> None:
    await session.execute(
        update(Trial).where(mine, Trial.status == "open").values(status="abandoned", ended_at=now)
    )


async def reopen_abandoned(session: AsyncSession, participant_id: int, step: str) -> None:
    """Open again what was given up at this step only because the participation had ended."""
    newest = (
        select(func.max(Trial.attempt))
        .where(Trial.participant_id == participant_id, Trial.step == step)
        .scalar_subquery()
    )
    await session.execute(
        update(Trial)
        .where(
            Trial.participant_id == participant_id,
            Trial.step == step,
            Trial.attempt == newest,
            Trial.status == "abandoned",
            Trial.state_hash.is_(None),
        )
        .values(status="open", ended_at=None)
    )


def _or_none(index: int) -> int | None:
    """An index, or None for the -1 that stands for “there is none”."""
    return index if index >= 0 else None


def _record(row: Trial) -> TrialRecord:
    return TrialRecord(
        id=row.id,
        participant_id=row.participant_id,
        step=row.step,
        attempt=row.attempt,
        kind=row.kind,
        position=row.position,
        condition=row.condition,
        label=row.label,
        scale=row.scale,
        seed=row.seed,
        config_hash=row.config_hash,
        config=row.config,
        policy_sha256=row.policy_sha256,
        status=row.status,
        learning_run_id=row.learning_run_id,
        ticks=row.ticks,
        state_hash=row.state_hash,
    )
