"""One move through the flow with everything that hangs on it, inside the caller's transaction.

A place in the design is claimed when the first explanation is reached (so nobody who fails the
check or the practice takes one), and given back when the participation ends without completion.
"""

from __future__ import annotations

from datetime import datetime, timedelta
from typing import Literal

from sqlalchemy.ext.asyncio import AsyncSession

from server.store.claims import ClaimEntry, add_entry, count_claimed, list_held, lock_ledger
from server.store.participants import (
    ParticipantRecord,
    list_idle,
    store_progress,
    store_slot,
)
from server.store.studies import list_same_design, read_version
from server.store.trials import abandon_open
from study.config import Study
from study.protocol.flow import IdleTooLong, Progress, Submission, advance
from study.protocol.orders import Slot, choose_slot

FIRST_TRIAL_STEP = "explanation-1"


async def move(
    session: AsyncSession,
    study: Study,
    participant: ParticipantRecord,
    submission: Submission,
    now: datetime,
) -> Progress:
    """Apply a submission; raises `WrongStep` if it does not belong to the current step."""
    before = participant.progress
    after = advance(study.plan, before, submission)
    if after == before:
        return before
    await store_progress(session, participant.id, after, now)
    if after.outcome != before.outcome and after.outcome is not None:
        await _close(session, participant, after.outcome, now)
    elif after.step == FIRST_TRIAL_STEP and participant.slot is None:
        await _claim(session, study, participant, now)
    return after


async def end_idle(session: AsyncSession, study: Study, now: datetime) -> int:
    """End participations of which nothing was heard for the study's limit; returns how many."""
    limit = now - timedelta(seconds=study.limits.idle_after_s)
    idle = await list_idle(session, study.study_id, limit)
    for participant in idle:
        joined = await read_version(session, participant.study_version_id)
        await move(session, joined, participant, IdleTooLong(), now)
    return len(idle)


async def _claim(
    session: AsyncSession, study: Study, participant: ParticipantRecord, now: datetime
) -> Slot:
    await lock_ledger(session, study.study_id)
    await end_idle(session, study, now)
    versions = await list_same_design(session, study)
    held = await list_held(session, study.study_id, participant.mode, versions)
    drawn = await count_claimed(session, study.study_id, participant.mode)
    slot = choose_slot(held, len(study.orders), study.seed, drawn)
    await store_slot(session, participant.id, slot)
    entry = ClaimEntry(
        participant.study_id, participant.mode, participant.id, slot, "claimed", "practice passed"
    )
    await add_entry(session, entry, now)
    return slot


async def _close(
    session: AsyncSession, participant: ParticipantRecord, outcome: str, now: datetime
) -> None:
    await abandon_open(session, participant.id, now)
    if participant.slot is None:
        return
    kind: Literal["completed", "released"] = "completed" if outcome == "completed" else "released"
    entry = ClaimEntry(
        participant.study_id,
        participant.mode,
        participant.id,
        participant.slot,
        kind,
        outcome,
    )
    await add_entry(session, entry, now)
