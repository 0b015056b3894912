"""Participants and their trials; excluding and reinstating."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query

from server.api.records import (
    Change,
    Limit,
    Mode,
    Name,
    Offset,
    Page,
    Participant,
    ParticipantDetail,
    Reason,
    Trial,
    Wanted,
)
from server.deps import AdminDep, ServicesDep
from server.store.participants import UnknownParticipant
from server.store.staff_lists import Listing
from server.store.trials import UnknownTrial
from study.protocol.lifecycle import Status

router = APIRouter(prefix="/api/v1", tags=["participants"])
TrialStatus = Annotated[str | None, Query(pattern="^(open|completed|timed_out|abandoned)$")]


@router.get("/participants")
async def list_participants(
    services: ServicesDep,
    user: AdminDep,
    study: Wanted = None,
    mode: Mode | None = None,
    status: Status | None = None,
    offset: Offset = 0,
    limit: Limit = 100,
) -> Page[Participant]:
    """One page of participants, oldest first."""
    rows, total = await services.stories.list_people(
        Listing(offset, limit, study or "", mode, status)
    )
    items = [Participant(**row) for row in rows]
    return Page(total=total, offset=offset, limit=limit, items=items)


@router.get("/participants/{code}")
async def read_participant(code: Name, services: ServicesDep, user: AdminDep) -> ParticipantDetail:
    """One participant with the history of the participation."""
    rows, _ = await services.stories.list_people(Listing(0, 1, code=code))
    if not rows:
        raise UnknownParticipant(code)
    _, changes = await services.lives.read_history(code)
    return ParticipantDetail(**rows[0], changes=[Change(**vars(entry)) for entry in changes])


@router.post("/participants/{code}/exclude")
async def exclude_participant(
    code: Name, why: Reason, services: ServicesDep, user: AdminDep
) -> ParticipantDetail:
    """Take a participant out of the analysis and give the place back."""
    await services.lives.exclude(code, why.reason, user.name)
    return await read_participant(code, services, user)


@router.post("/participants/{code}/reinstate")
async def reinstate_participant(
    code: Name, why: Reason, services: ServicesDep, user: AdminDep
) -> ParticipantDetail:
    """Take an exclusion back."""
    await services.lives.reinstate(code, why.reason, user.name)
    return await read_participant(code, services, user)


@router.get("/trials", tags=["trials"])
async def list_all_trials(
    services: ServicesDep,
    user: AdminDep,
    study: Wanted = None,
    participant: Wanted = None,
    mode: Mode | None = None,
    status: TrialStatus = None,
    offset: Offset = 0,
    limit: Limit = 100,
) -> Page[Trial]:
    """One page of participants' trials, oldest first."""
    wanted = Listing(offset, limit, study or "", mode, status, participant)
    rows, total = await services.stories.list_trials(wanted)
    return Page(total=total, offset=offset, limit=limit, items=[Trial(**row) for row in rows])


@router.get("/trials/{trial_id}", tags=["trials"])
async def read_trial(trial_id: Name, services: ServicesDep, user: AdminDep) -> Trial:
    """One trial of a participant."""
    rows, _ = await services.stories.list_trials(Listing(0, 1, trial_id=trial_id))
    if not rows:
        raise UnknownTrial(trial_id)
    return Trial(**rows[0])
