"""The administrators' page: who takes part, and the download of the data."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter
from starlette.responses import Response, StreamingResponse

from server.deps import AdminDep, ServicesDep
from server.export import MODES, ExportOptions
from server.export_process import begin_export
from server.pages.rendering import moment
from server.policy_desk import needs_confirmation
from server.store.participants import ParticipantRecord, count_by_status, list_participants
from server.store.users import add_audit
from server.trial_desk import utc_now
from study.config import Study
from study.errors import InvalidValue, UnknownStudy

router = APIRouter(prefix="/admin", include_in_schema=False)
PAGE_ROWS = 50


@router.get("")
async def show_participants(
    services: ServicesDep, user: AdminDep, study: str = "", page: int = 1
) -> Response:
    """One page of a study's participants, newest first."""
    shown = _find_study(services, study)
    page = max(1, min(page, 1_000_000))
    async with services.database.reading() as session:
        records, total = await list_participants(
            session, shown.study_id, offset=(page - 1) * PAGE_ROWS, limit=PAGE_ROWS
        )
        statuses = await count_by_status(session)
    counts: dict[str, int] = {}
    for (study_id, mode, status), number in sorted(statuses.items()):
        if study_id == shown.study_id:
            counts[f"{mode}, {status}"] = number
    values = {
        "user": user,
        "study": shown,
        "studies": list(services.participants.studies.values()),
        "participants": [_row(record, shown) for record in records],
        "counts": counts,
        "page": page,
        "pages": max(1, -(-total // PAGE_ROWS)),
        "policy": await _policy_values(services, shown),
    }
    return services.renderer.page("admin.html", values)


@router.get("/export")
async def download_export(
    services: ServicesDep, user: AdminDep, study: str = "", mode: str = ""
) -> Response:
    """The export as a zip, written while it is sent."""
    shown = _find_study(services, study)
    if mode and mode not in MODES:
        raise InvalidValue(
            f"there is no mode “{mode[:20]}”", next_step=f"Use one of {', '.join(MODES)}."
        )
    async with services.database.writing() as session:
        detail = f"{shown.study_id}, {mode or 'all modes'}"
        await add_audit(session, user.name, "export downloaded", detail, utc_now())
    options = ExportOptions(shown.study_id, mode or None)
    pieces = await begin_export(services.settings, options)
    name = f"{shown.study_id}-{mode or 'all'}-{utc_now():%Y%m%dT%H%M%SZ}.zip"
    return StreamingResponse(
        pieces,
        media_type="application/zip",
        headers={"Content-Disposition": f'attachment; filename="{name}"'},
    )


async def _policy_values(services: ServicesDep, study: Study) -> dict[str, Any] | None:
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


def _find_study(services: ServicesDep, study_id: str) -> Study:
    studies = services.participants.studies
    if not study_id and studies:
        return next(iter(studies.values()))
    if study_id not in studies:
        raise UnknownStudy(study_id)
    return studies[study_id]


def _row(record: ParticipantRecord, study: Study) -> dict[str, Any]:
    order = ""
    if record.slot is not None and record.slot.order_index < len(study.orders):
        order = " → ".join(study.orders[record.slot.order_index])
    return {
        "code": record.code,
        "mode": record.mode,
        "step": record.progress.step,
        "status": record.progress.life.status,
        "order": order,
        "joined": moment(record.joined_at),
        "seen": moment(record.seen_at),
        "ended": moment(record.ended_at),
    }
