"""How much is stored of a study, and what of it does not fit together."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from sqlalchemy import func, select
from sqlalchemy.ext.asyncio import AsyncSession

from server.store.tables import (
    Participant,
    Response,
    StaffNote,
    StudyVersion,
    Trial,
    TrialEvent,
    TrialLeg,
    TrialQuality,
    TrialRobot,
)

_NAMED = 20


async def count_rows(session: AsyncSession, study_id: str) -> dict[str, dict[str, int]]:
    """Rows of a study by table and mode."""
    people = select(Participant.mode, func.count()).where(Participant.study_id == study_id)
    trials = people.join(Trial, Trial.participant_id == Participant.id)
    last = select(func.max(TrialEvent.number) + 1).where(TrialEvent.trial_id == Trial.id)
    events = (
        select(Participant.mode, func.coalesce(func.sum(last.scalar_subquery()), 0))
        .join(Trial, Trial.participant_id == Participant.id)
        .where(Participant.study_id == study_id)
    )
    queries: dict[str, Any] = {
        "participants": people,
        "responses": people.join(Response, Response.participant_id == Participant.id),
        "trials": trials,
        "robots": trials.join(TrialRobot, TrialRobot.trial_id == Trial.id),
        "legs": trials.join(TrialLeg, TrialLeg.trial_id == Trial.id),
        "quality": trials.join(TrialQuality, TrialQuality.trial_id == Trial.id),
        "events": events,
        "notes": people.join(StaffNote, StaffNote.participant_id == Participant.id),
    }
    return {
        name: {mode: int(n) for mode, n in await session.execute(q.group_by(Participant.mode))}
        for name, q in queries.items()
    }


async def find_unmeasured(session: AsyncSession, study_id: str) -> list[str]:
    """Trials that count as completed but have no measures or no final state."""
    rows = await session.execute(
        select(Trial.id)
        .join(Participant, Participant.id == Trial.participant_id)
        .where(
            Participant.study_id == study_id,
            Trial.status == "completed",
            Trial.sum_wait_s.is_(None) | Trial.state_hash.is_(None),
        )
        .order_by(Trial.id)
        .limit(_NAMED)
    )
    return [trial_id for (trial_id,) in rows]


async def find_foreign_versions(session: AsyncSession, study_id: str) -> list[str]:
    """Trials whose version of the study is not the one that their participant joined."""
    rows = await session.execute(
        select(Trial.id)
        .join(Participant, Participant.id == Trial.participant_id)
        .join(StudyVersion, StudyVersion.id == Participant.study_version_id)
        .where(Participant.study_id == study_id, Trial.config_hash != StudyVersion.config_hash)
        .order_by(Trial.id)
        .limit(_NAMED)
    )
    return [trial_id for (trial_id,) in rows]


async def find_incomplete(
    session: AsyncSession, study_id: str, wanted: Mapping[int, tuple[int, int]]
) -> list[str]:
    """Codes of completed participants with fewer answers or trials than their version asks for.

    `wanted`: answers that must be there and trials, by id of the version.
    """
    done = (Participant.study_id == study_id, Participant.status == "completed")
    alive = Participant.erased_at.is_(None)
    answers = await session.execute(
        select(Participant.code, Participant.study_version_id, func.count(Response.id))
        .join(Response, Response.participant_id == Participant.id, isouter=True)
        .where(*done, alive)
        .group_by(Participant.id)
    )
    short = {code for code, version, n in answers if n < wanted.get(version, (0, 0))[0]}
    trials = await session.execute(
        select(Participant.code, Participant.study_version_id, func.count(Trial.id))
        .join(
            Trial,
            (Trial.participant_id == Participant.id)
            & (Trial.kind == "trial")
            & (Trial.status != "open"),
            isouter=True,
        )
        .where(*done, alive)
        .group_by(Participant.id)
    )
    short |= {code for code, version, n in trials if n < wanted.get(version, (0, 0))[1]}
    return sorted(short)[:_NAMED]
