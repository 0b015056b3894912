"""Participants: joining, being found by token, and moving through the steps."""

from __future__ import annotations

import hashlib
import secrets
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import cast

from sqlalchemy import func, select, update
from sqlalchemy.ext.asyncio import AsyncSession

from server.store.tables import PanelId, Participant
from study.errors import UnknownToken
from study.protocol.flow import Outcome, Progress
from study.protocol.orders import Slot

_CODE_LETTERS = "23456789ABCDEFGHJKMNPQRSTVWXYZ"


@dataclass(frozen=True)
class ParticipantRecord:
    """What the server knows of a participant; never the token."""

    id: int
    code: str
    study_version_id: int
    study_id: str
    mode: str
    is_bot: bool
    progress: Progress
    slot: Slot | None
    joined_at: datetime
    seen_at: datetime
    step_shown_at: datetime | None
    ended_at: datetime | None


@dataclass(frozen=True)
class NewParticipant:
    """What is fixed when somebody joins."""

    token: str
    study_version_id: int
    study_id: str
    mode: str
    is_bot: bool
    progress: Progress
    panel_ids: Mapping[str, str]


def hash_token(token: str) -> str:
    """SHA-256 of a token in hex: all that is stored of it."""
    return hashlib.sha256(token.encode()).hexdigest()


async def add_participant(session: AsyncSession, new: NewParticipant, now: datetime) -> None:
    """Store a participant; one who has joined with this token already is left as is."""
    known = await session.scalar(
        select(Participant.id).where(Participant.token_hash == hash_token(new.token))
    )
    if known is not None:
        return
    row = Participant(
        code="P-" + "".join(secrets.choice(_CODE_LETTERS) for _ in range(8)),
        token_hash=hash_token(new.token),
        study_version_id=new.study_version_id,
        study_id=new.study_id,
        mode=new.mode,
        is_bot=new.is_bot,
        step=new.progress.step,
        practice_tries=0,
        joined_at=now,
        seen_at=now,
    )
    session.add(row)
    await session.flush()
    session.add_all(
        PanelId(participant_id=row.id, name=name, value=value)
        for name, value in new.panel_ids.items()
    )
    await session.flush()


async def find_participant(
    session: AsyncSession, token: str, *, lock: bool = False
) -> ParticipantRecord:
    """The participant with this token; `lock` holds the row until the transaction ends."""
    query = select(Participant).where(Participant.token_hash == hash_token(token))
    row = await session.scalar(query.with_for_update() if lock else query)
    if row is None:
        raise UnknownToken
    return _record(row)


async def read_participant(
    session: AsyncSession, participant_id: int, *, lock: bool = False
) -> ParticipantRecord:
    """The participant with this id."""
    query = select(Participant).where(Participant.id == participant_id)
    return _record((await session.scalars(query.with_for_update() if lock else query)).one())


async def store_progress(
    session: AsyncSession, participant_id: int, progress: Progress, now: datetime
) -> None:
    """Note where the participant is now."""
    await session.execute(
        update(Participant)
        .where(Participant.id == participant_id)
        .values(
            step=progress.step,
            practice_tries=progress.practice_tries,
            outcome=progress.outcome,
            seen_at=now,
            step_shown_at=None,
            ended_at=now if progress.outcome else None,
        )
    )


async def store_slot(session: AsyncSession, participant_id: int, slot: Slot) -> None:
    """Note the place in the design that the participant was given."""
    await session.execute(
        update(Participant)
        .where(Participant.id == participant_id)
        .values(block=slot.block, order_index=slot.order_index)
    )


async def note_shown(session: AsyncSession, participant_id: int, now: datetime) -> None:
    """Note that a page was shown; the first time of the current step is kept."""
    await session.execute(
        update(Participant)
        .where(Participant.id == participant_id)
        .values(seen_at=now, step_shown_at=func.coalesce(Participant.step_shown_at, now))
    )


async def list_idle(
    session: AsyncSession, study_id: str, seen_before: datetime
) -> list[ParticipantRecord]:
    """Participants under way last seen before this moment; those busy elsewhere are left out."""
    rows = await session.scalars(
        select(Participant)
        .where(
            Participant.study_id == study_id,
            Participant.outcome.is_(None),
            Participant.seen_at < seen_before,
        )
        .with_for_update(skip_locked=True)
    )
    return [_record(row) for row in rows]


async def list_participants(
    session: AsyncSession, study_id: str, *, offset: int, limit: int
) -> tuple[list[ParticipantRecord], int]:
    """One page of a study's participants, newest first, and how many there are."""
    here = Participant.study_id == study_id
    count = await session.scalar(select(func.count()).select_from(Participant).where(here))
    rows = await session.scalars(
        select(Participant).where(here).order_by(Participant.id.desc()).offset(offset).limit(limit)
    )
    return [_record(row) for row in rows], count or 0


async def count_by_outcome(session: AsyncSession) -> dict[tuple[str, str, str], int]:
    """Number of participants by (study, mode, outcome), `active` while under way."""
    rows = await session.execute(
        select(Participant.study_id, Participant.mode, Participant.outcome, func.count()).group_by(
            Participant.study_id, Participant.mode, Participant.outcome
        )
    )
    return {(study, mode, outcome or "active"): count for study, mode, outcome, count in rows}


def _record(row: Participant) -> ParticipantRecord:
    slot = None
    if row.block is not None and row.order_index is not None:
        slot = Slot(row.block, row.order_index)
    return ParticipantRecord(
        id=row.id,
        code=row.code,
        study_version_id=row.study_version_id,
        study_id=row.study_id,
        mode=row.mode,
        is_bot=row.is_bot,
        progress=Progress(row.step, row.practice_tries, cast("Outcome | None", row.outcome)),
        slot=slot,
        joined_at=row.joined_at,
        seen_at=row.seen_at,
        step_shown_at=row.step_shown_at,
        ended_at=row.ended_at,
    )
