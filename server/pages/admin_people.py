"""Administrators' list of participants: filtered, sorted, a page at a time."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter
from starlette.responses import Response

from server.pages.admin_frame import Frame, FrameDep, clamp_page, query_of
from server.store.dashboard import SORTS, Wanted
from server.store.participants import ParticipantRecord
from study.config import Study
from study.protocol.lifecycle import STATUSES

router = APIRouter(prefix="/admin/participants", include_in_schema=False)
PAGE_ROWS = 50


@router.get("")
async def show_participants(
    frame: FrameDep,
    status: str = "",
    order: str = "",
    text: str = "",
    sort: str = "-joined",
    page: int = 1,
) -> Response:
    """One page of the participants wanted."""
    page, study = clamp_page(page), frame.study
    wanted = _read_wanted(frame, (status, order, text[:40], sort))
    records, total = await frame.services.stories.search(
        wanted, offset=(page - 1) * PAGE_ROWS, limit=PAGE_ROWS
    )
    chosen = {"status": wanted.status, "order": order if wanted.order_index is not None else ""}
    keep = {"study": study.study_id, "mode": frame.mode, **chosen, "text": wanted.text}
    values = {
        "participants": [describe_person(record, study) for record in records],
        "total": total,
        "page": page,
        "pages": max(1, -(-total // PAGE_ROWS)),
        "chosen": chosen | {"text": wanted.text},
        "sort": sort,
        "statuses": ("under-way", *STATUSES),
        "orders": [" → ".join(one) for one in study.orders],
        "sort_query": query_of(**keep),
        "page_query": query_of(**keep, sort=sort),
        "is_filtered": any((frame.mode, *chosen.values(), wanted.text)),
    }
    return frame.page("admin-participants.html", values)


def _read_wanted(frame: Frame, asked: tuple[str, str, str, str]) -> Wanted:
    """What the address asks for; what makes no sense there stands for everything."""
    status, order, text, sort = asked
    index = int(order) if order.isascii() and order.isdigit() and len(order) < 6 else None
    known = status if status in ("under-way", *STATUSES) else ""
    column = sort.removeprefix("-")
    return Wanted(
        study_id=frame.study.study_id,
        mode=frame.mode,
        status=known,
        order_index=index,
        text=text.replace("\x00", ""),
        sort=column if column in SORTS else "joined",
        descending=sort.startswith("-") or column not in SORTS,
    )


def describe_person(record: ParticipantRecord, study: Study) -> dict[str, Any]:
    """A participant as lists and the story show one."""
    order = ""
    if record.slot is not None and record.slot.order_index < len(study.orders):
        order = " → ".join(study.orders[record.slot.order_index])
    return {
        "code": record.code,
        "study_id": record.study_id,
        "mode": record.mode,
        "step": record.progress.step,
        "status": record.progress.life.status,
        "before": record.progress.life.before,
        "block": None if record.slot is None else record.slot.block,
        "order": order,
        "joined": record.joined_at,
        "seen": record.seen_at,
        "ended": record.ended_at,
        "erased": record.erased_at,
    }
