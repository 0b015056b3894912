"""One move of a participant with everything that hangs on it, inside the caller's transaction.

A place in the design is claimed when the first explanation is reached (so nobody who fails the
check or the practice takes one), given back when the participation ends without completion, and
taken again by one who is reinstated.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from datetime import datetime, timedelta
from typing import Literal

from sqlalchemy.ext.asyncio import AsyncSession

from server.store.claims import ClaimEntry, add_entry, count_claimed, list_held, lock_ledger
from server.store.lives import StatusChange, add_change
from server.store.participants import (
    ParticipantRecord,
    list_paused_players,
    list_unseen,
    store_life,
    store_progress,
    store_slot,
)
from server.store.studies import list_same_design
from server.store.trials import abandon_open, reopen_abandoned
from study.config import Study
from study.protocol.flow import IdleTooLong, Progress, Submission, Withdrawal, advance
from study.protocol.lifecycle import REASONS, UNDER_WAY, Act, Life, Status, change
from study.protocol.orders import Slot, choose_slot

FIRST_TRIAL_STEP = "explanation-1"
PAUSED_AFTER_S = 300.0
PARTICIPANT, SERVER = "participant", "server"
PRESENT: tuple[Status, ...] = ("active",)
EntryKind = Literal["claimed", "completed", "released"]


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
    if (after.step, after.practice_tries) != (before.step, before.practice_tries):
        await store_progress(session, participant.id, after, now)
    if after.life != before.life:
        act = _act_of(submission, before.life, after.life)
        actor = SERVER if isinstance(submission, IdleTooLong) else PARTICIPANT
        await _change_life(session, participant, after.life, (REASONS[act], actor), now)
    if after.step == FIRST_TRIAL_STEP and participant.slot is None:
        await _claim(session, study, participant, now)
    return after


async def alter(
    session: AsyncSession,
    participant: ParticipantRecord,
    act: Act,
    cause: tuple[str, str],
    now: datetime,
) -> Life:
    """Change the life without a step; `cause` is the reason and the actor.

    Raises `WrongChange` if the act does not fit.
    """
    before = participant.progress.life
    after = change(before, act)
    if after != before:
        await _change_life(session, participant, after, cause, now)
    return after


async def pause_absent(session: AsyncSession, study: Study, now: datetime) -> int:
    """Count those as paused of whom nothing was heard for five minutes; returns how many."""
    limit = now - timedelta(seconds=PAUSED_AFTER_S)
    absent = await list_unseen(session, study.study_id, limit, PRESENT)
    for participant in absent:
        await alter(session, participant, "pause", (REASONS["pause"], SERVER), now)
    return len(absent)


async def welcome_back(
    session: AsyncSession, participants: Collection[ParticipantRecord], now: datetime
) -> None:
    """Whoever was paused is under way again."""
    for participant in participants:
        await alter(session, participant, "return", (REASONS["return"], PARTICIPANT), now)


async def welcome_players(session: AsyncSession, trial_ids: Collection[str], now: datetime) -> None:
    """Whoever was paused and plays one of these trials is under way again."""
    await welcome_back(session, await list_paused_players(session, trial_ids), now)


async def end_idle(session: AsyncSession, study: Study, now: datetime) -> int:
    """End participations of which nothing was heard for the study's limit; returns how many."""
    limit = now - timedelta(seconds=study.limits.idle_after_s)
    idle = await list_unseen(session, study.study_id, limit, UNDER_WAY, now)
    for participant in idle:
        await alter(session, participant, "time-out", (REASONS["time-out"], SERVER), now)
    return len(idle)


async def _change_life(
    session: AsyncSession,
    participant: ParticipantRecord,
    after: Life,
    cause: tuple[str, str],
    now: datetime,
) -> None:
    before, (reason, actor) = participant.progress.life, cause
    await store_life(session, participant.id, after, now)
    entry = StatusChange(before.status, after.status, reason, actor)
    await add_change(session, participant.id, entry, now)
    if after.outcome is not None:
        await abandon_open(session, participant.id, now)
    elif before.outcome is not None:
        await reopen_abandoned(session, participant.id, participant.progress.step)
    await _settle_place(session, participant, after, now)


async def _settle_place(
    session: AsyncSession, participant: ParticipantRecord, after: Life, now: datetime
) -> None:
    """Write into the ledger what the change means for the participant's place."""
    before = participant.progress.life
    if participant.slot is None:
        return
    if _holds_place(before) and not _holds_place(after):
        await _enter(session, participant, "released", after.status, now)
    elif _holds_place(after) and not _holds_place(before):
        await _enter(session, participant, "claimed", "reinstated", now)
    if after.status == "completed" and before.status != "completed":
        await _enter(session, participant, "completed", "completed", now)


async def _enter(
    session: AsyncSession,
    participant: ParticipantRecord,
    kind: EntryKind,
    reason: str,
    now: datetime,
) -> None:
    if participant.slot is not None:
        entry = ClaimEntry(
            participant.study_id, participant.mode, participant.id, participant.slot, kind, reason
        )
        await add_entry(session, entry, now)


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
    placed = replace(participant, slot=slot)
    await _enter(session, placed, "claimed", "practice passed", now)
    return slot


def _holds_place(life: Life) -> bool:
    return life.status in UNDER_WAY or life.status == "completed"


def _act_of(submission: Submission, before: Life, after: Life) -> Act:
    """What happened to the life when a submission was applied."""
    if isinstance(submission, Withdrawal):
        return "withdraw"
    if isinstance(submission, IdleTooLong):
        return "time-out"
    if after.status == "completed":
        return "complete"
    if after.status == "screened-out":
        return "screen-out"
    return "begin" if before.status == "joined" else "return"
