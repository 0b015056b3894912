"""The ledger of places in the design. Rows are only added; who holds a place is read off them."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from datetime import datetime
from typing import Literal

from sqlalchemy import func, select
from sqlalchemy.ext.asyncio import AsyncSession
from sqlalchemy.orm import aliased

from server.store.tables import Claim, Participant, StudyVersion
from study.protocol.orders import Slot


@dataclass(frozen=True)
class ClaimEntry:
    """One row of the ledger."""

    study_id: str
    mode: str
    participant_id: int
    slot: Slot
    kind: Literal["claimed", "completed", "released"]
    reason: str


async def lock_ledger(session: AsyncSession, study_id: str) -> None:
    """Let one transaction at a time give away places of a study."""
    await session.execute(
        select(StudyVersion.id).where(StudyVersion.study_id == study_id).with_for_update()
    )


async def list_held(
    session: AsyncSession, study_id: str, mode: str, versions: Collection[int]
) -> list[Slot]:
    """Places claimed and not released, in the order claimed, by those who joined these versions."""
    released = aliased(Claim)
    given_back = (
        select(released.id)
        .where(
            released.participant_id == Claim.participant_id,
            released.kind == "released",
            released.id > Claim.id,
        )
        .exists()
    )
    rows = await session.execute(
        select(Claim.block, Claim.order_index)
        .join(Participant, Participant.id == Claim.participant_id)
        .where(Claim.study_id == study_id, Claim.mode == mode, Claim.kind == "claimed", ~given_back)
        .where(Participant.study_version_id.in_(versions))
        .order_by(Claim.id)
    )
    return [Slot(block, order_index) for block, order_index in rows]


async def count_claimed(session: AsyncSession, study_id: str, mode: str) -> int:
    """How many places were ever given away."""
    count = await session.scalar(
        select(func.count())
        .select_from(Claim)
        .where(Claim.study_id == study_id, Claim.mode == mode, Claim.kind == "claimed")
    )
    return count or 0


async def add_entry(session: AsyncSession, entry: ClaimEntry, now: datetime) -> None:
    """Write one row into the ledger."""
    session.add(
        Claim(
            study_id=entry.study_id,
            mode=entry.mode,
            participant_id=entry.participant_id,
            block=entry.slot.block,
            order_index=entry.slot.order_index,
            kind=entry.kind,
            reason=entry.reason,
            at=now,
        )
    )
    await session.flush()
