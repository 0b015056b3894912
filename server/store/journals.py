"""Journals of running trials: chunks of inputs and events, each stored once however often sent."""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

from sqlalchemy import select, update
from sqlalchemy.ext.asyncio import AsyncSession

from server.store.inserting import insert_new
from server.store.tables import LearningRun, Participant, Trial, TrialChunk, TrialEvent
from study.records.events import JournalEvent
from study.records.journal import JournalChunk

if TYPE_CHECKING:
    from datetime import datetime

    from server.live.ports import TrialBatch

SLICE = 40
T = TypeVar("T")
_HASH = struct.Struct("<I8s")


async def lock_open(session: AsyncSession, trial_ids: Sequence[str]) -> set[str]:
    """Which of these trials are still running; they cannot end before the transaction does."""
    found: set[str] = set()
    for some in _slices(sorted(set(trial_ids))):
        owners = select(Trial.participant_id).where(Trial.id.in_(some))
        lock = select(Participant.id).where(Participant.id.in_(owners)).order_by(Participant.id)
        await session.execute(lock.with_for_update())
        runs = select(Trial.learning_run_id).where(Trial.id.in_(some))
        held = select(LearningRun.id).where(LearningRun.id.in_(runs)).order_by(LearningRun.id)
        await session.execute(held.with_for_update())
        running = select(Trial.id).where(Trial.id.in_(some), Trial.status == "open")
        found |= set(await session.scalars(running))
    return found


async def add_batches(session: AsyncSession, batches: Sequence[TrialBatch], now: datetime) -> None:
    """Store new chunks and events of many trials; what is stored already is left alone."""
    newest = {batch.trial_id: batch for batch in batches}
    # Participants first: everybody else who locks both locks them in this order.
    for trial_ids in _slices(list(newest)):
        owners = select(Trial.participant_id).where(Trial.id.in_(trial_ids))
        seen = update(Participant).where(Participant.id.in_(owners)).values(seen_at=now)
        await session.execute(seen)
    for trials in _slices(list(newest.values())):
        places = [{"id": b.trial_id, "ticks": b.tick, "phase": b.phase} for b in trials]
        await session.execute(update(Trial), places)
    for some in _slices(batches):
        chunks = [_chunk_row(b.trial_id, b.chunk) for b in some if b.chunk is not None]
        events = [_event_row(b.trial_id, event) for b in some for event in b.events]
        await insert_new(session, TrialChunk, chunks)
        await insert_new(session, TrialEvent, events)


def _slices(rows: Sequence[T]) -> Iterator[Sequence[T]]:
    """Parts so small that making their statements holds no trial's tick up."""
    return (rows[n : n + SLICE] for n in range(0, len(rows), SLICE))


async def read_journal(
    session: AsyncSession, trial_id: str
) -> tuple[tuple[JournalChunk, ...], tuple[JournalEvent, ...]]:
    """Everything stored of a trial's journal, oldest first."""
    chunks = await session.scalars(
        select(TrialChunk).where(TrialChunk.trial_id == trial_id).order_by(TrialChunk.first_tick)
    )
    events = await session.scalars(
        select(TrialEvent).where(TrialEvent.trial_id == trial_id).order_by(TrialEvent.number)
    )
    return tuple(_read_chunk(row) for row in chunks), tuple(_read_event(row) for row in events)


def _chunk_row(trial_id: str, chunk: JournalChunk) -> dict[str, Any]:
    return {
        "trial_id": trial_id,
        "first_tick": chunk.first_tick,
        "ticks": chunk.ticks,
        "last_seq": chunk.last_seq,
        "inputs": chunk.inputs,
        "hashes": b"".join(_HASH.pack(tick, digest) for tick, digest in chunk.hashes),
    }


def _event_row(trial_id: str, event: JournalEvent) -> dict[str, Any]:
    return {
        "trial_id": trial_id,
        "number": event.number,
        "tick": event.tick,
        "kind": event.kind,
        "at": event.at_utc,
        "data": dict(event.data),
    }


def _read_chunk(row: TrialChunk) -> JournalChunk:
    return JournalChunk(
        first_tick=row.first_tick,
        ticks=row.ticks,
        inputs=row.inputs,
        hashes=tuple((tick, digest) for tick, digest in _HASH.iter_unpack(row.hashes)),
        last_seq=row.last_seq,
    )


def _read_event(row: TrialEvent) -> JournalEvent:
    return JournalEvent(row.number, row.tick, row.kind, row.at, row.data)
