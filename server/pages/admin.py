"""The administrators' overview: how far everybody got, the cells, and what is wrong."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter
from starlette.responses import Response

from server.deps import AdminDeskDep, Services
from server.desks.policies import needs_confirmation
from server.export.bundle import ExportOptions
from server.export.download import answer_download
from server.pages.admin_frame import FrameDep
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
    options = ExportOptions(
        frame.study.study_id, frame.mode or None, bool(telemetry), bool(panel_ids)
    )
    services = frame.services
    return await answer_download(services.settings, services.audit, options, frame.user.name)


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
