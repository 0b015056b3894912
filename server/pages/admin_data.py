"""Administrators' pages about the data: what is stored, the ledger of places, the audit."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter
from starlette.responses import Response

from server.deps import AdminDeskDep
from server.export.items import study_items
from server.pages.admin_frame import FrameDep, clamp_page, query_of
from server.store.dashboard import list_blocks, list_ledger
from server.store.data_checks import (
    count_rows,
    find_foreign_versions,
    find_incomplete,
    find_unmeasured,
)
from server.store.stories import AuditWanted, list_audited, search_audit
from server.store.studies import list_ids
from study.config import Study
from study.protocol.balance import spread
from study.records.codebook import codebook_rows

router = APIRouter(prefix="/admin", include_in_schema=False)
PAGE_ROWS = 50
BLOCKS = 24


@router.get("/data")
async def show_data(frame: FrameDep) -> Response:
    """How much is stored, what does not fit together, and the downloads."""
    study_id = frame.study.study_id
    async with frame.services.database.reading() as session:
        rows = await count_rows(session, study_id)
        versions = await list_ids(session, study_id)
        wanted = {number: _wanted(study) for number, study in versions.items()}
        checks = [
            (
                "Every completed trial has its measures and its final state",
                await find_unmeasured(session, study_id),
            ),
            (
                "Everybody who completed has every trial and every required answer",
                await find_incomplete(session, study_id, wanted),
            ),
            (
                "Every trial has the version that its participant joined",
                await find_foreign_versions(session, study_id),
            ),
        ]
    return frame.page("admin-data.html", {"rows": rows, "checks": checks})


@router.get("/data/codebook")
async def show_codebook(frame: FrameDep, file: str = "") -> Response:
    """What every column and every item means, file by file."""
    study = frame.study
    rows = list(codebook_rows(study_items(study.config_hash, study)))
    files = sorted({row["file"] for row in rows})
    shown = file if file in files else files[0]
    values = {
        "files": files,
        "shown": shown,
        "rows": [row for row in rows if row["file"] == shown],
    }
    return frame.page("admin-codebook.html", values)


@router.get("/conditions")
async def show_conditions(frame: FrameDep, desk: AdminDeskDep, page: int = 1) -> Response:
    """The cells now and as predicted, the newest blocks, and the ledger."""
    page, study = clamp_page(page), frame.study
    summary = await desk.sum_up(study, frame.counted)
    async with frame.services.database.reading() as session:
        blocks = await list_blocks(session, study.study_id, frame.counted, newest=BLOCKS)
        ledger, total = await list_ledger(
            session,
            study.study_id,
            frame.counted,
            offset=(page - 1) * PAGE_ROWS,
            limit=PAGE_ROWS,
        )
    values = {
        "counted": frame.counted,
        "cells": summary.cells,
        "spread": spread(summary.cells),
        "blocks": blocks,
        "ledger": ledger,
        "total": total,
        "page": page,
        "pages": max(1, -(-total // PAGE_ROWS)),
        "page_query": query_of(study=study.study_id, mode=frame.mode),
    }
    return frame.page("admin-conditions.html", values)


@router.get("/audit")
async def show_audit(frame: FrameDep, who: str = "", text: str = "", page: int = 1) -> Response:
    """What staff did, newest first."""
    page = clamp_page(page)
    wanted = AuditWanted(who[:64], text[:80].replace("\x00", ""))
    async with frame.services.database.reading() as session:
        names = await list_audited(session)
        entries, total = await search_audit(
            session, wanted, offset=(page - 1) * PAGE_ROWS, limit=PAGE_ROWS
        )
    values: dict[str, Any] = {
        "entries": entries,
        "names": names,
        "wanted": wanted,
        "total": total,
        "page": page,
        "pages": max(1, -(-total // PAGE_ROWS)),
        "page_query": query_of(who=wanted.user_name, text=wanted.text),
    }
    return frame.page("admin-audit.html", values)


def _wanted(study: Study) -> tuple[int, int]:
    """How many answers and trials a completed participant of this version has at least."""
    needed = 0
    for kind in ("consent", "demographics", "questionnaire", "final", "comments"):
        asked = sum(bool(item.required) for _, item in study.items_asked(kind))
        needed += asked * (len(study.conditions) if kind == "questionnaire" else 1)
    return needed, len(study.conditions)
