"""Participants: joining, being found by token, and moving through the steps."""

from __future__ import annotations

import hashlib
import secrets
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import cast

from sqlalchemy import func, select, update
from sqlalchemy.ext.asyncio import AsyncSession

from server.store.inserting import insert_new
from server.store.lives import StatusChange, add_change
from server.store.tables import PanelId, Participant, Trial
from study.errors import NotFound, UnknownToken
from study.protocol.flow import Progress
from study.protocol.lifecycle import Life, Status
from study.protocol.orders import Slot

_CODE_LETTERS = "23456789ABCDEFGHJKMNPQRSTVWXYZ"


class UnknownParticipant(NotFound):
    """No participant has this code."""

    def __init__(self, code: str) -> None:
        self.code = code
        super().__init__(
            f"there is no participant “{code[:40]}”",
            next_step="Take the code, as P-XXXXXXXX, from the list of participants or the export.",
        )


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
    erased_at: datetime | None


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
    row = {
        "code": "P-" + "".join(secrets.choice(_CODE_LETTERS) for _ in range(8)),
        "token_hash": hash_token(new.token),
        "study_version_id": new.study_version_id,
        "study_id": new.study_id,
        "mode": new.mode,
        "is_bot": new.is_bot,
        "step": new.progress.step,
        "practice_tries": 0,
        "status": new.progress.life.status,
        "joined_at": now,
        "seen_at": now,
    }
    if not await insert_new(session, Participant, [row]):
        return
    added = (await find_participant(session, new.token)).id
    cause = (
        ("issued as simulated", "server") if new.is_bot else ("pressed the button", "participant")
    )
    joined = StatusChange(None, new.progress.life.status, *cause)
    await add_change(session, added, joined, now)
    session.add_all(
        PanelId(participant_id=added, name=name, value=value)
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
    """Note where the participant is now; a new step has not been shown yet."""
    await session.execute(
        update(Participant)
        .where(Participant.id == participant_id)
        .values(
            step=progress.step,
            practice_tries=progress.practice_tries,
            seen_at=now,
            step_shown_at=None,
        )
    )


async def store_life(session: AsyncSession, participant_id: int, life: Life, now: datetime) -> None:
    """Note how the participation stands; when it first ended is kept."""
    ended = None if life.outcome is None else func.coalesce(Participant.ended_at, now)
    await session.execute(
        update(Participant)
        .where(Participant.id == participant_id)
        .values(status=life.status, status_before=life.before, ended_at=ended)
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


async def list_unseen(
    session: AsyncSession, study_id: str, seen_before: datetime, statuses: Collection[Status]
) -> list[ParticipantRecord]:
    """Participants last seen before this moment; those busy elsewhere are left out."""
    rows = await session.scalars(
        select(Participant)
        .where(
            Participant.study_id == study_id,
            Participant.status.in_(statuses),
            Participant.seen_at < seen_before,
        )
        .order_by(Participant.id)
        .with_for_update(skip_locked=True)
    )
    return [_record(row) for row in rows]


async def list_paused_players(
    session: AsyncSession, trial_ids: Collection[str]
) -> list[ParticipantRecord]:
    """Those counted as paused among the participants of these trials."""
    rows = await session.execute(
        select(Participant, Trial.id)
        .join(Trial, Trial.participant_id == Participant.id)
        .where(Participant.status == "paused", Trial.status == "open")
    )
    return [_record(row) for row, trial_id in rows if trial_id in trial_ids]


async def find_by_code(
    session: AsyncSession, code: str, *, lock: bool = False
) -> ParticipantRecord:
    """The participant with this code, whatever its case; raises `UnknownParticipant`."""
    query = select(Participant).where(Participant.code == code.strip().upper())
    row = await session.scalar(query.with_for_update() if lock else query)
    if row is None:
        raise UnknownParticipant(code)
    return _record(row)


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


async def count_by_status(session: AsyncSession) -> dict[tuple[str, str, str], int]:
    """Number of participants by (study, mode, status)."""
    rows = await session.execute(
        select(Participant.study_id, Participant.mode, Participant.status, func.count()).group_by(
            Participant.study_id, Participant.mode, Participant.status
        )
    )
    return {(study, mode, status): count for study, mode, status, count in rows}


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
        progress=Progress(
            row.step,
            row.practice_tries,
            Life(cast("Status", row.status), cast("Status | None", row.status_before)),
        ),
        slot=slot,
        joined_at=row.joined_at,
        seen_at=row.seen_at,
        step_shown_at=row.step_shown_at,
        ended_at=row.ended_at,
        erased_at=row.erased_at,
    )
