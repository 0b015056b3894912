"""Participants and their trials; excluding and reinstating."""

from __future__ import annotations

from typing import Annotated, Any

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
from server.deps import AdminDep, Services, ServicesDep
from server.desks.lives import LifeDesk
from server.store.participants import UnknownParticipant
from server.store.staff_lists import Listing, list_people, list_trials
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
    rows, total = await _read_people(services, Listing(offset, limit, study or "", mode, status))
    items = [Participant(**row) for row in rows]
    return Page(total=total, offset=offset, limit=limit, items=items)


@router.get("/participants/{code}")
async def read_participant(code: Name, services: ServicesDep, user: AdminDep) -> ParticipantDetail:
    """One participant with the history of the participation."""
    rows, _ = await _read_people(services, Listing(0, 1, code=code))
    if not rows:
        raise UnknownParticipant(code)
    _, changes = await LifeDesk(services.database).read_history(code)
    return ParticipantDetail(**rows[0], changes=[Change(**vars(entry)) for entry in changes])


@router.post("/participants/{code}/exclude")
async def exclude_participant(
    code: Name, why: Reason, services: ServicesDep, user: AdminDep
) -> ParticipantDetail:
    """Take a participant out of the analysis and give the place back."""
    await LifeDesk(services.database).exclude(code, why.reason, user.name)
    return await read_participant(code, services, user)


@router.post("/participants/{code}/reinstate")
async def reinstate_participant(
    code: Name, why: Reason, services: ServicesDep, user: AdminDep
) -> ParticipantDetail:
    """Take an exclusion back."""
    await LifeDesk(services.database).reinstate(code, why.reason, user.name)
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
    async with services.database.reading() as session:
        rows, total = await list_trials(session, wanted)
    return Page(total=total, offset=offset, limit=limit, items=[Trial(**row) for row in rows])


@router.get("/trials/{trial_id}", tags=["trials"])
async def read_trial(trial_id: Name, services: ServicesDep, user: AdminDep) -> Trial:
    """One trial of a participant."""
    async with services.database.reading() as session:
        rows, _ = await list_trials(session, Listing(0, 1, trial_id=trial_id))
    if not rows:
        raise UnknownTrial(trial_id)
    return Trial(**rows[0])


async def _read_people(services: Services, wanted: Listing) -> tuple[list[dict[str, Any]], int]:
    async with services.database.reading() as session:
        return await list_people(session, wanted)
