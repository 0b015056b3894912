"""Administrators' page about the study itself: its versions, the launch checklist, its texts."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Any

from fastapi import APIRouter, Request
from starlette.responses import Response

from server.deps import AdminDeskDep
from server.desks.participants import Visit
from server.pages.admin_frame import FrameDep
from server.pages.views import View, view_step
from server.store.participants import ParticipantRecord
from study.config import Study
from study.protocol.checklist import Surroundings, check_launch
from study.protocol.flow import Progress, UnknownStep
from study.protocol.lifecycle import Life
from study.protocol.orders import Slot

router = APIRouter(prefix="/admin/study", include_in_schema=False)
_EARLY_ENDS = ("screened-out", "withdrawn", "timed-out", "excluded")
_LONG_AGO = datetime(2000, 1, 1, tzinfo=UTC)


@router.get("")
async def show_study(frame: FrameDep, desk: AdminDeskDep, request: Request) -> Response:
    """Versions, checklist and the pages as participants see them."""
    study = frame.study
    versions, tried = await frame.services.data.list_versions(study.study_id)
    active = await frame.services.policies.find_active(study)
    around = Surroundings(
        tried=tried,
        policy_origin=None if active is None else active.policy.origin,
        time_scale=desk.time_scale,
        is_https=request.url.scheme == "https",
    )
    values: dict[str, Any] = {
        "versions": versions[::-1],
        "points": check_launch(study, around),
        "steps": [*_pages(study), *_EARLY_ENDS],
    }
    return frame.page("admin-study.html", values)


@router.get("/preview/{step}")
async def preview_step(step: str, frame: FrameDep, order: int = 0) -> Response:
    """A page as a participant of this order would see it; nothing on it can be sent."""
    study = frame.study
    if step not in (*_pages(study), *_EARLY_ENDS):
        raise UnknownStep(step)
    view = _view(study, step, max(0, min(order, len(study.orders) - 1)))
    return frame.services.renderer.page(view.template, dict(view.values) | {"preview": True})


def _view(study: Study, step: str, order: int) -> View:
    life = Life("active")
    at = step
    if step in _EARLY_ENDS:
        life, at = Life(step), study.plan.steps[0]  # type: ignore[arg-type]
    elif step == "debrief":
        life = Life("completed")
    somebody = ParticipantRecord(
        id=0,
        code="P-PREVIEW",
        study_version_id=0,
        study_id=study.study_id,
        mode="pilot",
        is_bot=False,
        progress=Progress(at, 0, life),
        slot=Slot(0, order),
        joined_at=_LONG_AGO,
        seen_at=_LONG_AGO,
        step_shown_at=None,
        ended_at=None,
        erased_at=None,
    )
    return view_step(Visit(somebody, study), "/admin/study/preview")


def _pages(study: Study) -> list[str]:
    """The steps that are pages to read or fill in."""
    return [s for s in study.plan.steps if s != "practice" and not s.startswith("trial-")]
