"""Studies and their exports, as JSON and as a zip."""

from __future__ import annotations

import json
from typing import Any

from fastapi import APIRouter
from starlette.responses import StreamingResponse

from server.api.records import Mode, Name, StudyDetail, StudySummary
from server.deps import AdminDep, ServicesDep
from server.export.bundle import ExportOptions
from server.export.download import answer_download
from study.config import Study

router = APIRouter(prefix="/api/v1/studies", tags=["studies"])
_ZIP: dict[int | str, dict[str, Any]] = {200: {"content": {"application/zip": {}}}}


@router.get("")
async def list_studies(services: ServicesDep, user: AdminDep) -> list[StudySummary]:
    """Every study that can be joined here, with its counts."""
    counts = await services.data.count_statuses()
    return [
        StudySummary(**_summary(study, counts)) for study in services.participants.studies.values()
    ]


@router.get("/{study_id}")
async def read_study(study_id: Name, services: ServicesDep, user: AdminDep) -> StudyDetail:
    """One study with its whole definition."""
    study = services.participants.find_study(study_id)
    return StudyDetail(
        **_summary(study, await services.data.count_statuses()),
        orders=[list(order) for order in study.orders],
        steps=list(study.plan.steps),
        definition=json.loads(study.canonical_json),
    )


@router.get("/{study_id}/export", tags=["export"], responses=_ZIP, response_class=StreamingResponse)
async def export_study(
    study_id: Name,
    services: ServicesDep,
    user: AdminDep,
    mode: Mode | None = None,
    telemetry: bool = False,
) -> StreamingResponse:
    """The export bundle as a zip, written while it is sent."""
    study = services.participants.find_study(study_id)
    options = ExportOptions(study.study_id, mode, telemetry=telemetry)
    return await answer_download(services.settings, services.audit, options, user.name)


def _summary(study: Study, counts: dict[tuple[str, str, str], int]) -> dict[str, Any]:
    here: dict[str, dict[str, int]] = {}
    for (study_id, mode, status), number in counts.items():
        if study_id == study.study_id:
            here.setdefault(mode, {})[status] = number
    return {
        "study_id": study.study_id,
        "title": study.title,
        "config_hash": study.config_hash,
        "recruiting": study.recruiting,
        "conditions": list(study.conditions),
        "planned_participants": study.planned_participants,
        "counts": here,
    }
