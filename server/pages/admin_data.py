"""Administrators' pages about the data: what is stored, the ledger of places, the audit."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter
from starlette.responses import Response

from server.deps import AdminDeskDep
from server.export.items import study_items
from server.pages.admin_frame import FrameDep, clamp_page, query_of
from server.store.audit import AuditWanted
from study.protocol.balance import spread
from study.records.codebook import codebook_rows

router = APIRouter(prefix="/admin", include_in_schema=False)
PAGE_ROWS = 50


@router.get("/data")
async def show_data(frame: FrameDep) -> Response:
    """How much is stored, what does not fit together, and the downloads."""
    stored = await frame.services.data.examine(frame.study.study_id)
    return frame.page("admin-data.html", {"rows": stored.rows, "checks": stored.checks})


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
    places = await frame.services.data.list_places(
        study.study_id, frame.counted, offset=(page - 1) * PAGE_ROWS, limit=PAGE_ROWS
    )
    values = {
        "counted": frame.counted,
        "cells": summary.cells,
        "spread": spread(summary.cells),
        "blocks": places.blocks,
        "ledger": places.ledger,
        "total": places.total,
        "page": page,
        "pages": max(1, -(-places.total // PAGE_ROWS)),
        "page_query": query_of(study=study.study_id, mode=frame.mode),
    }
    return frame.page("admin-conditions.html", values)


@router.get("/audit")
async def show_audit(frame: FrameDep, who: str = "", text: str = "", page: int = 1) -> Response:
    """What staff did, newest first."""
    page = clamp_page(page)
    wanted = AuditWanted(who[:64], text[:80].replace("\x00", ""))
    names, entries, total = await frame.services.audit.search(
        wanted, offset=(page - 1) * PAGE_ROWS, limit=PAGE_ROWS
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
