"""One participant's whole story: trials with measures and quality, answers, events, notes."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from typing import Any

from sqlalchemy import func, select
from sqlalchemy.ext.asyncio import AsyncSession

from server.store.dashboard import LedgerEntry, ledger_rows
from server.store.tables import (
    Claim,
    Response,
    StaffNote,
    Trial,
    TrialEvent,
    TrialQuality,
)

Row = dict[str, Any]
LONGEST_NOTE = 500


@dataclass(frozen=True)
class Note:
    """What a member of staff wrote, and about which moment of which trial."""

    at: datetime
    user_name: str
    text: str
    trial_id: str | None
    tick: int | None


async def list_trials(session: AsyncSession, participant_id: int) -> list[Row]:
    """A participant's trials in the order opened, with measures and quality."""
    quality = [c for c in TrialQuality.__table__.columns if c.name != "trial_id"]
    columns = [c for c in Trial.__table__.columns if c.name not in ("config", "state_hash")]
    rows = await session.execute(
        select(*columns, *quality)
        .join(TrialQuality, TrialQuality.trial_id == Trial.id, isouter=True)
        .where(Trial.participant_id == participant_id)
        .order_by(Trial.opened_at, Trial.id)
    )
    return [dict(row) for row in rows.mappings()]


async def list_answers(session: AsyncSession, participant_id: int) -> list[Row]:
    """A participant's answers in the order given."""
    rows = await session.execute(
        select(
            Response.step,
            Response.item,
            Response.value,
            Response.shown_at,
            Response.answered_at,
        )
        .where(Response.participant_id == participant_id)
        .order_by(Response.answered_at, Response.id)
    )
    return [dict(row) for row in rows.mappings()]


async def count_events(session: AsyncSession, participant_id: int) -> dict[str, dict[str, int]]:
    """Numbers of events by trial and kind."""
    rows = await session.execute(
        select(TrialEvent.trial_id, TrialEvent.kind, func.count())
        .join(Trial, Trial.id == TrialEvent.trial_id)
        .where(Trial.participant_id == participant_id)
        .group_by(TrialEvent.trial_id, TrialEvent.kind)
        .order_by(TrialEvent.kind)
    )
    counts: dict[str, dict[str, int]] = {}
    for trial_id, kind, number in rows:
        counts.setdefault(trial_id, {})[kind] = number
    return counts


async def list_claims(session: AsyncSession, participant_id: int) -> list[LedgerEntry]:
    """A participant's rows of the ledger, oldest first."""
    mine = Claim.participant_id == participant_id
    rows = await session.execute(ledger_rows().where(mine).order_by(Claim.id))
    return [LedgerEntry(*row) for row in rows]


async def add_note(session: AsyncSession, participant_id: int, note: Note) -> None:
    """Keep a note about a participant, or about a moment of a trial."""
    session.add(
        StaffNote(
            participant_id=participant_id,
            trial_id=note.trial_id,
            tick=note.tick,
            at=note.at,
            user_name=note.user_name[:64],
            text=note.text[:LONGEST_NOTE],
        )
    )
    await session.flush()


async def list_notes(session: AsyncSession, participant_id: int) -> list[Note]:
    """The notes about a participant, oldest first."""
    rows = await session.scalars(
        select(StaffNote).where(StaffNote.participant_id == participant_id).order_by(StaffNote.id)
    )
    return [Note(row.at, row.user_name, row.text, row.trial_id, row.tick) for row in rows]
