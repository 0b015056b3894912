"""The history of participations: why each changed, when and by whom; and erasure.

Erasing takes away everything that a participant gave or caused, and leaves the row in
`participants` and the ledger as a tombstone, so that counts still add up.
"""

from __future__ import annotations

import secrets
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any, cast

from sqlalchemy import delete, select, update
from sqlalchemy.ext.asyncio import AsyncSession

from server.store.tables import (
    PanelId,
    Participant,
    ParticipantChange,
    Response,
    StaffNote,
    Trial,
    TrialChunk,
    TrialEvent,
    TrialLeg,
    TrialQuality,
    TrialRobot,
)
from study.protocol.lifecycle import Status

PARTS_OF_A_TRIAL = (TrialChunk, TrialEvent, TrialLeg, TrialRobot, TrialQuality)
ERASED_REASON = "erased"


@dataclass(frozen=True)
class StatusChange:
    """One entry of a participation's history; `was` is None for joining."""

    was: Status | None
    now: Status
    reason: str
    actor: str
    at: datetime | None = None


async def add_change(
    session: AsyncSession, participant_id: int, entry: StatusChange, now: datetime
) -> None:
    """Write one entry into the history."""
    session.add(
        ParticipantChange(
            participant_id=participant_id,
            at=now,
            from_status=entry.was,
            to_status=entry.now,
            reason=entry.reason[:200],
            actor=entry.actor[:64],
        )
    )
    await session.flush()


async def list_changes(session: AsyncSession, participant_id: int) -> list[StatusChange]:
    """The history of a participation, oldest first."""
    rows = await session.scalars(
        select(ParticipantChange)
        .where(ParticipantChange.participant_id == participant_id)
        .order_by(ParticipantChange.id)
    )
    return [
        StatusChange(
            cast("Status | None", row.from_status),
            cast("Status", row.to_status),
            row.reason,
            row.actor,
            row.at,
        )
        for row in rows
    ]


async def erase_data(session: AsyncSession, participant_id: int, now: datetime) -> dict[str, int]:
    """Delete all that belongs to a participant but the tombstone; returns rows by table.

    The personal link stops working, and reasons that staff wrote are blanked.
    """
    trials = list(
        await session.scalars(select(Trial.id).where(Trial.participant_id == participant_id))
    )
    gone = {"panel_ids": await _delete(session, PanelId.participant_id, [participant_id])}
    gone["staff_notes"] = await _delete(session, StaffNote.participant_id, [participant_id])
    gone["responses"] = await _delete(session, Response.participant_id, [participant_id])
    for table in PARTS_OF_A_TRIAL:
        gone[table.__tablename__] = await _delete(session, cast("Any", table).trial_id, trials)
    gone["trials"] = await _delete(session, Trial.id, trials)
    await session.execute(
        update(ParticipantChange)
        .where(
            ParticipantChange.participant_id == participant_id,
            ParticipantChange.actor.not_in(("participant", "server")),
        )
        .values(reason=ERASED_REASON)
    )
    await session.execute(
        update(Participant)
        .where(Participant.id == participant_id)
        .values(erased_at=now, token_hash=f"erased-{secrets.token_hex(24)}", step_shown_at=None)
    )
    return gone


async def _delete(session: AsyncSession, column: Any, values: Sequence[Any]) -> int:
    if not values:
        return 0
    done = await session.execute(delete(column.class_).where(column.in_(values)))
    return int(cast("Any", done).rowcount)
