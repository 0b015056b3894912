"""A study with as many participants as wanted, in every state there is, with all their rows."""

from __future__ import annotations

from datetime import datetime, timedelta
from typing import Any

from sqlalchemy import insert, select, update
from sqlalchemy.ext.asyncio import AsyncSession

from server.store.bench_people import START, add_bench_people
from server.store.engine import Database
from server.store.tables import (
    AuditEntry,
    Claim,
    Participant,
    ParticipantChange,
    StaffNote,
    Trial,
)
from study.config import Study

# Of ten: six complete, one each is under way, timed out, withdrawn and excluded afterwards.
ENDS: tuple[dict[str, Any], ...] = (
    {"status": "active", "step": "trial-2", "ended_at": None},
    {"status": "timed-out", "step": "trial-1"},
    {"status": "withdrawn", "step": "questionnaire-2"},
    {"status": "excluded", "status_before": "completed"},
)
REASONS = ("began", "stayed away", "asked to", "a second participation of the same person")


async def add_crowd(database: Database, study: Study, people: int, now: datetime) -> None:
    """Pilots of a study with trials, answers, claims, changes, notes and an audit of 3 a person."""
    if people == 0:
        return
    await add_bench_people(database, study, people)
    async with database.writing() as session:
        await session.execute(update(Participant).values(mode="pilot", is_bot=False))
        await _claim_places(session, study, people)
        for place, (end, reason) in enumerate(zip(ENDS, REASONS, strict=True)):
            those = [n for n in range(1, people + 1) if n % 10 == place + 2]
            await _let_end(session, those, end, reason, now)
        await _write_about(session, people, now)


async def _claim_places(session: AsyncSession, study: Study, people: int) -> None:
    orders = len(study.orders)
    rows = [
        {"study_id": study.study_id, "mode": "pilot", "participant_id": n, "block": n // orders}
        | {"order_index": n % orders, "kind": kind, "reason": reason, "at": START}
        for n in range(1, people + 1)
        for kind, reason in (("claimed", "demographics sent"), ("completed", "did every step"))
        if kind == "claimed" or n % 10 not in (2, 3, 4)
    ]
    await session.execute(insert(Claim), rows)


async def _let_end(
    session: AsyncSession, those: list[int], end: dict[str, Any], reason: str, now: datetime
) -> None:
    if not those:
        return
    seen = now - timedelta(minutes=7) if end["status"] == "active" else START
    await session.execute(
        update(Participant).where(Participant.id.in_(those)).values(**end, seen_at=seen)
    )
    await session.execute(
        insert(ParticipantChange),
        [
            {"participant_id": n, "at": START, "from_status": "active", "to_status": end["status"]}
            | {"reason": reason, "actor": "server"}
            for n in those
        ],
    )
    if end["status"] == "active":
        await session.execute(
            update(Trial)
            .where(Trial.participant_id.in_(those), Trial.position == 2)
            .values(status="open", ended_at=None, phase="running")
        )


async def _write_about(session: AsyncSession, people: int, now: datetime) -> None:
    first = await session.scalar(select(Trial.id).order_by(Trial.id).limit(1))
    audit = [
        {"at": now - timedelta(minutes=n), "user_name": ("maria", "ben")[n % 2]}
        | {"action": "note written", "detail": f"P-B{1 + n % people:07d}: trial-2 at tick 900"}
        for n in range(3 * people)
    ]
    notes = [
        {"participant_id": 1, "trial_id": first, "tick": 900 * n, "at": now, "user_name": "maria"}
        | {"text": "Stood before station 3 for long, then asked what the balloon means."}
        for n in range(min(people, 3))
    ]
    await session.execute(insert(AuditEntry), audit)
    await session.execute(insert(StaffNote), notes)
