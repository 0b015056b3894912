"""Rows of the export as plain values, streamed: a table is never held in memory as a whole.

Of people who withdrew only the row in `participants` is given: their data are not to be used.
"""

from __future__ import annotations

from collections.abc import AsyncIterator
from typing import Any

from sqlalchemy import select
from sqlalchemy.ext.asyncio import AsyncSession

from server.store.tables import (
    Participant,
    Response,
    StudyVersion,
    Trial,
    TrialLeg,
    TrialRobot,
)

FETCH_ROWS = 500
_ORIGIN = (
    Participant.code.label("participant_code"),
    Participant.study_id,
    StudyVersion.config_hash.label("config_hash"),
    Participant.mode,
    Participant.is_bot,
)
_MEASURES = (
    "status",
    "ticks",
    "duration_s",
    "sum_wait_s",
    "sum_completion_s",
    "slowest_robot_s",
    "human_path_m",
    "human_still_s",
    "blocked_by_human_s",
)

Rows = AsyncIterator[dict[str, Any]]
Query = Any  # a select of any columns: its row type has no name that fits them all


def participant_rows(session: AsyncSession, study_id: str, mode: str | None) -> Rows:
    """Everybody, with step, status and place in the design."""
    query = select(
        *_ORIGIN,
        Participant.status,
        Participant.step,
        Participant.order_index,
        Participant.block,
        Participant.practice_tries,
        Participant.joined_at,
        Participant.ended_at,
    ).join(StudyVersion, StudyVersion.id == Participant.study_version_id)
    return _stream(session, _narrow(query, study_id, mode).order_by(Participant.id))


def trial_rows(session: AsyncSession, study_id: str, mode: str | None) -> Rows:
    """Trials after the practice."""
    query = select(
        *_ORIGIN,
        Trial.id.label("trial_id"),
        Trial.position,
        Trial.condition,
        Trial.scale,
        Trial.seed,
        Trial.policy_sha256,
        *(getattr(Trial, name) for name in _MEASURES),
    )
    return _stream(session, _trials_only(query, study_id, mode))


def robot_rows(session: AsyncSession, study_id: str, mode: str | None) -> Rows:
    """Robots of those trials."""
    query = select(
        *_ORIGIN,
        TrialRobot.trial_id,
        TrialRobot.robot,
        TrialRobot.boxes_delivered,
        TrialRobot.wait_s,
        TrialRobot.completion_s,
        TrialRobot.path_m,
        TrialRobot.longest_stall_s,
    )
    ordered = _trials_only(query, study_id, mode).order_by(TrialRobot.robot)
    return _stream(session, ordered.where(TrialRobot.trial_id == Trial.id))


def leg_rows(session: AsyncSession, study_id: str, mode: str | None) -> Rows:
    """Legs of those robots."""
    query = select(
        *_ORIGIN,
        TrialLeg.trial_id,
        TrialLeg.robot,
        TrialLeg.leg,
        TrialLeg.state,
        TrialLeg.start_s,
        TrialLeg.end_s,
        TrialLeg.path_m,
        TrialLeg.shelf,
        TrialLeg.box,
        TrialLeg.station,
        TrialLeg.ended,
    )
    ordered = _trials_only(query, study_id, mode).order_by(TrialLeg.robot, TrialLeg.leg)
    return _stream(session, ordered.where(TrialLeg.trial_id == Trial.id))


def response_rows(session: AsyncSession, study_id: str, mode: str | None) -> Rows:
    """Answers, with the order index from which the condition is found."""
    query = (
        select(
            *_ORIGIN,
            Participant.order_index,
            Response.step,
            Response.item,
            Response.item_order,
            Response.value,
            Response.shown_at,
            Response.answered_at,
        )
        .join(Participant, Participant.id == Response.participant_id)
        .join(StudyVersion, StudyVersion.id == Participant.study_version_id)
    )
    kept = _narrow(query, study_id, mode).where(_not_withdrawn())
    return _stream(session, kept.order_by(Participant.id, Response.id))


def _trials_only(query: Query, study_id: str, mode: str | None) -> Query:
    joined = (
        query.select_from(Trial)
        .join(Participant, Participant.id == Trial.participant_id)
        .join(StudyVersion, StudyVersion.id == Participant.study_version_id)
    )
    kept = _narrow(joined, study_id, mode).where(Trial.kind == "trial", _not_withdrawn())
    return kept.order_by(Participant.id, Trial.position)


def _narrow(query: Query, study_id: str, mode: str | None) -> Query:
    here = query.where(Participant.study_id == study_id)
    return here if mode is None else here.where(Participant.mode == mode)


def _not_withdrawn() -> Any:
    return Participant.status != "withdrawn"


async def _stream(session: AsyncSession, query: Query) -> Rows:
    rows = await session.stream(query.execution_options(yield_per=FETCH_ROWS))
    async for row in rows.mappings():
        yield dict(row)
