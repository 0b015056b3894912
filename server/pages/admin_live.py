"""Administrators' pages about running and past trials: who is where, watching, replaying."""

from __future__ import annotations

import re

from fastapi import APIRouter
from starlette.responses import RedirectResponse, Response

from server.dashboard.people import describe_people
from server.deps import AdminDep, AdminDeskDep, FormDep, ServicesDep
from server.pages.admin_frame import FrameDep
from study.errors import InvalidValue

router = APIRouter(prefix="/admin", include_in_schema=False)
MINUTES = (10, 30, 60, 240)
_TICK = re.compile(r"[0-9]{1,9}")


@router.get("/live")
async def show_live(frame: FrameDep, desk: AdminDeskDep) -> Response:
    """Who is under way and where; the page keeps itself up to date over a socket."""
    people = await describe_people(frame.services.database, desk.watch, frame.study.study_id)
    return frame.page("admin-live.html", {"people": people})


@router.get("/live/{trial}")
async def watch_trial(
    trial: str, services: ServicesDep, user: AdminDep, desk: AdminDeskDep
) -> Response:
    """A running trial in 3D; one that is not running leads to its replay."""
    record, code = await services.stories.find_trial(trial)
    if desk.watch.describe(trial) is None and record.status != "open":
        return RedirectResponse(f"/admin/replay/{trial}", 303)
    values = {
        "user": user,
        "trial": record,
        "code": code,
        "is_replay": False,
        "minutes": MINUTES,
    }
    return services.renderer.page("admin-watch.html", values)


@router.get("/replay/{trial}")
async def replay_trial(trial: str, services: ServicesDep, user: AdminDep) -> Response:
    """A stored trial, re-simulated from its journal."""
    record, code = await services.stories.find_trial(trial)
    values = {"user": user, "trial": record, "code": code, "is_replay": True}
    return services.renderer.page("admin-watch.html", values | {"minutes": ()})


@router.post("/live/{trial}/note")
async def note_moment(
    trial: str, form: FormDep, services: ServicesDep, user: AdminDep, desk: AdminDeskDep
) -> Response:
    """Keep a note about the moment that is on the screen."""
    record, _ = await services.stories.find_trial(trial)
    tick = form.get("tick", "")
    if not _TICK.fullmatch(tick):
        raise InvalidValue(
            f"“{tick[:20]}” is no tick", next_step="Load the page again and write the note there."
        )
    await desk.note_trial(record.id, int(tick), form.get("note", ""), user.name)
    back = "replay" if form.get("from") == "replay" else "live"
    return RedirectResponse(f"/admin/{back}/{record.id}", 303)


@router.post("/live/{trial}/extend")
async def extend_time(
    trial: str, form: FormDep, services: ServicesDep, user: AdminDep, desk: AdminDeskDep
) -> Response:
    """Wait longer for an absent participant."""
    record, _ = await services.stories.find_trial(trial)
    minutes = form.get("minutes", "")
    if minutes not in map(str, MINUTES):
        known = ", ".join(map(str, MINUTES))
        raise InvalidValue(f"“{minutes[:20]}” is no choice", next_step=f"Choose one of {known}.")
    await desk.extend(record.id, int(minutes), user.name)
    return RedirectResponse(f"/admin/live/{record.id}", 303)
