"""Pages of participants and trials as the interface for programs lists them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sqlalchemy import func, select
from sqlalchemy.ext.asyncio import AsyncSession

from server.store.tables import Participant, StudyVersion, Trial

_PERSON = (
    Participant.code,
    Participant.study_id,
    StudyVersion.config_hash,
    Participant.mode,
    Participant.is_bot,
    Participant.status,
    Participant.step,
    Participant.block,
    Participant.order_index,
    Participant.practice_tries,
    Participant.joined_at,
    Participant.seen_at,
    Participant.ended_at,
    Participant.erased_at,
)
_TRIAL = (
    Trial.id.label("trial_id"),
    Participant.code.label("participant_code"),
    Participant.study_id,
    Participant.mode,
    Participant.is_bot,
    Trial.step,
    Trial.attempt,
    Trial.kind,
    Trial.position,
    Trial.condition,
    Trial.scale,
    Trial.seed,
    Trial.config_hash,
    Trial.policy_sha256,
    Trial.status,
    Trial.ticks,
    Trial.opened_at,
    Trial.ended_at,
    Trial.duration_s,
    Trial.sum_wait_s,
    Trial.sum_completion_s,
    Trial.slowest_robot_s,
)
Row = dict[str, Any]


@dataclass(frozen=True)
class Listing:
    """Which rows: those that equal every value given; `None` and empty texts select nothing."""

    offset: int
    limit: int
    study_id: str = ""
    mode: str | None = None
    status: str | None = None
    code: str | None = None
    trial_id: str | None = None


async def list_people(session: AsyncSession, wanted: Listing) -> tuple[list[Row], int]:
    """One page of participants, oldest first, and how many there are."""
    query = select(*_PERSON).join(StudyVersion, StudyVersion.id == Participant.study_version_id)
    query = _choose(query, wanted, Participant.status)
    return await _page(session, query, Participant.id, wanted)


async def list_trials(session: AsyncSession, wanted: Listing) -> tuple[list[Row], int]:
    """One page of participants' trials, oldest first, practice included, and how many there are."""
    query = select(*_TRIAL).join(Participant, Participant.id == Trial.participant_id)
    query = _choose(query, wanted, Trial.status)
    if wanted.trial_id is not None:
        query = query.where(Trial.id == wanted.trial_id)
    return await _page(session, query, Trial.opened_at, wanted)


def _choose(query: Any, wanted: Listing, status: Any) -> Any:
    if wanted.study_id:
        query = query.where(Participant.study_id == wanted.study_id)
    if wanted.mode is not None:
        query = query.where(Participant.mode == wanted.mode)
    if wanted.status is not None:
        query = query.where(status == wanted.status)
    if wanted.code is not None:
        query = query.where(Participant.code == wanted.code.strip().upper())
    return query


async def _page(
    session: AsyncSession, query: Any, order: Any, wanted: Listing
) -> tuple[list[Row], int]:
    count = await session.scalar(select(func.count()).select_from(query.subquery()))
    page = query.order_by(order).offset(wanted.offset).limit(wanted.limit)
    rows = (await session.execute(page)).mappings()
    return [dict(row) for row in rows], count or 0
