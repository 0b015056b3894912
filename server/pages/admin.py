"""The administrators' overview: how far everybody got, the cells, and what is wrong."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter
from starlette.responses import Response, StreamingResponse

from server.deps import AdminDeskDep, Services
from server.desks.policies import needs_confirmation
from server.desks.trials import utc_now
from server.export.bundle import ExportOptions
from server.export.process import begin_export
from server.pages.admin_frame import FrameDep
from server.store.users import add_audit
from study.config import Study

router = APIRouter(prefix="/admin", include_in_schema=False)


@router.get("")
async def show_overview(frame: FrameDep, desk: AdminDeskDep) -> Response:
    """The flow of participants, the cells against their targets, and the alarms."""
    summary = await desk.sum_up(frame.study, frame.counted)
    values = {
        "counted": frame.counted,
        "flow": summary.flow,
        "cells": summary.cells,
        "alarms": summary.alarms,
        "by_mode": summary.modes,
        "rooms": desk.watch.judge_loop(),
        "policy": await _policy_values(frame.services, frame.study),
    }
    return frame.page("admin.html", values)


@router.get("/export")
async def download_export(frame: FrameDep, telemetry: str = "", panel_ids: str = "") -> Response:
    """The export as a zip, written while it is sent."""
    study, mode = frame.study, frame.mode
    options = ExportOptions(study.study_id, mode or None, bool(telemetry), bool(panel_ids))
    with_more = "".join(
        text
        for wanted, text in (
            (options.telemetry, ", with telemetry"),
            (options.panel_ids, ", with panel ids"),
        )
        if wanted
    )
    async with frame.services.database.writing() as session:
        detail = f"{study.study_id}, {mode or 'all modes'}{with_more}"
        await add_audit(session, frame.user.name, "export downloaded", detail, utc_now())
    pieces = await begin_export(frame.services.settings, options)
    name = f"{study.study_id}-{mode or 'all'}-{utc_now():%Y%m%dT%H%M%SZ}.zip"
    return StreamingResponse(
        pieces,
        media_type="application/zip",
        headers={"Content-Disposition": f'attachment; filename="{name}"'},
    )


async def _policy_values(services: Services, study: Study) -> dict[str, Any] | None:
    """The policy that the study runs, with its origin; None if no condition of it runs one."""
    active = await services.policies.find_active(study)
    if active is None:
        return None
    return {
        "name": active.policy.name,
        "origin": active.policy.origin,
        "sha256": active.policy.sha256,
        "warn": needs_confirmation(active.policy, study),
    }
