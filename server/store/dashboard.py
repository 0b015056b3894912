"""What the administrators' pages count and list: everything grouped or paged in the database."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from typing import Any, Literal, cast

from sqlalchemy import ColumnElement, Select, func, or_, select
from sqlalchemy.ext.asyncio import AsyncSession

from server.store.participants import ParticipantRecord, as_record
from server.store.tables import Claim, Participant, Trial
from study.protocol.consort import Crowd
from study.protocol.lifecycle import UNDER_WAY, Status

Sort = Literal["joined", "seen", "code", "status", "step", "order"]
_SORTS: dict[str, Any] = {
    "joined": Participant.id,
    "seen": Participant.seen_at,
    "code": Participant.code,
    "status": Participant.status,
    "step": Participant.step,
    "order": Participant.order_index,
}
SORTS: tuple[str, ...] = tuple(_SORTS)


@dataclass(frozen=True)
class Wanted:
    """Which participants a list shows, and in which order; empty texts stand for all."""

    study_id: str
    mode: str = ""
    status: str = ""
    order_index: int | None = None
    text: str = ""
    sort: str = "joined"
    descending: bool = True


@dataclass(frozen=True)
class LedgerEntry:
    """One row of the ledger of places with whose it is."""

    at: datetime
    code: str
    mode: str
    block: int
    order_index: int
    kind: str
    reason: str


@dataclass(frozen=True)
class Player:
    """Somebody under way, with the trial that is open, if any."""

    participant: ParticipantRecord
    trial_id: str | None
    trial_label: str
    condition: str


async def count_crowds(session: AsyncSession, study_id: str) -> list[Crowd]:
    """The participants of a study in groups of those who stand alike."""
    keys = (
        Participant.mode,
        Participant.status,
        Participant.status_before,
        Participant.step,
        Participant.order_index,
    )
    rows = await session.execute(
        select(*keys, func.count()).where(Participant.study_id == study_id).group_by(*keys)
    )
    return [
        Crowd(mode, cast("Status", status), cast("Status | None", before), step, order, number)
        for mode, status, before, step, order, number in rows
    ]


async def count_away(session: AsyncSession, study_id: str, mode: str, before: datetime) -> int:
    """How many under way were last heard of before this moment."""
    count = await session.scalar(
        select(func.count())
        .select_from(Participant)
        .where(
            Participant.study_id == study_id,
            Participant.mode == mode,
            Participant.status.in_(UNDER_WAY),
            Participant.seen_at < before,
        )
    )
    return count or 0


async def search_participants(
    session: AsyncSession, wanted: Wanted, *, offset: int, limit: int
) -> tuple[list[ParticipantRecord], int]:
    """One page of the participants wanted, and how many there are."""
    here = _conditions(wanted)
    count = await session.scalar(select(func.count()).select_from(Participant).where(*here))
    column = _SORTS[wanted.sort]
    order = column.desc() if wanted.descending else column.asc()
    rows = await session.scalars(
        select(Participant)
        .where(*here)
        .order_by(order, Participant.id.desc())
        .offset(offset)
        .limit(limit)
    )
    return [as_record(row) for row in rows], count or 0


async def list_ledger(
    session: AsyncSession, study_id: str, mode: str, *, offset: int, limit: int
) -> tuple[list[LedgerEntry], int]:
    """One page of the ledger, newest first, and how many rows it has."""
    here = (Claim.study_id == study_id, Claim.mode == mode)
    count = await session.scalar(select(func.count()).select_from(Claim).where(*here))
    wanted = ledger_rows().where(*here).order_by(Claim.id.desc())
    rows = await session.execute(wanted.offset(offset).limit(limit))
    return [LedgerEntry(*row) for row in rows], count or 0


def ledger_rows() -> Select[datetime, str, str, int, int, str, str]:
    """The fields of ledger entries, each with whose it is."""
    return select(
        Claim.at,
        Participant.code,
        Claim.mode,
        Claim.block,
        Claim.order_index,
        Claim.kind,
        Claim.reason,
    ).join(Participant, Participant.id == Claim.participant_id)


async def list_blocks(
    session: AsyncSession, study_id: str, mode: str, *, newest: int
) -> dict[int, dict[int, str]]:
    """Of the newest blocks, each order's holder: block -> order -> status of who holds it."""
    here = (
        Participant.study_id == study_id,
        Participant.mode == mode,
        Participant.status.in_((*UNDER_WAY, "completed")),
        Participant.block.is_not(None),
    )
    last = await session.scalar(select(func.max(Participant.block)).where(*here))
    if last is None:
        return {}
    rows = await session.execute(
        select(Participant.block, Participant.order_index, Participant.status).where(
            *here, Participant.block > last - newest
        )
    )
    blocks: dict[int, dict[int, str]] = {
        block: {} for block in range(max(0, last - newest + 1), last + 1)
    }
    for block, order_index, status in rows:
        if block is not None and order_index is not None:
            blocks[block][order_index] = status
    return blocks


async def list_players(
    session: AsyncSession, study_id: str, *, limit: int
) -> tuple[list[Player], int]:
    """Those under way who were heard of last, and how many there are in all."""
    here = (Participant.study_id == study_id, Participant.status.in_(UNDER_WAY))
    count = await session.scalar(select(func.count()).select_from(Participant).where(*here))
    people = list(
        await session.scalars(
            select(Participant)
            .where(*here)
            .order_by(Participant.seen_at.desc(), Participant.id.desc())
            .limit(limit)
        )
    )
    trials = await session.execute(
        select(Trial.participant_id, Trial.id, Trial.label, Trial.condition).where(
            Trial.participant_id.in_([row.id for row in people]), Trial.status == "open"
        )
    )
    opened = {owner: (trial, label, condition) for owner, trial, label, condition in trials}
    return [
        Player(as_record(row), *opened.get(row.id, (None, "", ""))) for row in people
    ], count or 0


def _conditions(wanted: Wanted) -> list[ColumnElement[bool]]:
    here: list[ColumnElement[bool]] = [Participant.study_id == wanted.study_id]
    if wanted.mode:
        here.append(Participant.mode == wanted.mode)
    if wanted.status == "under-way":
        here.append(Participant.status.in_(UNDER_WAY))
    elif wanted.status:
        here.append(Participant.status == wanted.status)
    if wanted.order_index is not None:
        here.append(Participant.order_index == wanted.order_index)
    if wanted.text:
        part = wanted.text.strip()
        here.append(
            or_(
                Participant.code.icontains(part, autoescape=True),
                Participant.step.icontains(part, autoescape=True),
            )
        )
    return here
