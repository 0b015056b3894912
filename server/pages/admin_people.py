"""Administrators' pages about participants: the list, one whole story, excluding, notes."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime
from typing import Any

from fastapi import APIRouter
from starlette.responses import RedirectResponse, Response

from server.deps import AdminDep, AdminDeskDep, FormDep, ServicesDep
from server.desks.lives import LifeDesk
from server.pages.admin_frame import Frame, FrameDep, clamp_page, query_of
from server.store.dashboard import SORTS, Wanted, search_participants
from server.store.lives import list_changes
from server.store.participants import ParticipantRecord, find_by_code
from server.store.stories import count_events, list_answers, list_claims, list_notes, list_trials
from server.store.studies import read_version
from study.config import Study
from study.errors import InvalidValue
from study.protocol.exclusions import flag_participant, flag_trial
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
    async with frame.services.database.reading() as session:
        records, total = await search_participants(
            session, wanted, offset=(page - 1) * PAGE_ROWS, limit=PAGE_ROWS
        )
    chosen = {"status": wanted.status, "order": order if wanted.order_index is not None else ""}
    keep = {"study": study.study_id, "mode": frame.mode, **chosen, "text": wanted.text}
    values = {
        "participants": [_row(record, study) for record in records],
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


@router.get("/{code}")
async def show_participant(
    code: str, services: ServicesDep, user: AdminDep, desk: AdminDeskDep
) -> Response:
    """Everything that is known of one participant."""
    return await _story(Frame(services, user, _any_study(services), ""), desk, code, {})


@router.post("/{code}/exclude")
async def exclude(
    code: str, form: FormDep, services: ServicesDep, user: AdminDep, desk: AdminDeskDep
) -> Response:
    """Take a participant out of the analysis, with a reason."""
    return await _alter("exclude", code, form, (services, user, desk))


@router.post("/{code}/reinstate")
async def reinstate(
    code: str, form: FormDep, services: ServicesDep, user: AdminDep, desk: AdminDeskDep
) -> Response:
    """Take an exclusion back, with a reason."""
    return await _alter("reinstate", code, form, (services, user, desk))


@router.post("/{code}/note")
async def write_note(
    code: str, form: FormDep, services: ServicesDep, user: AdminDep, desk: AdminDeskDep
) -> Response:
    """Keep a note about a participant."""
    try:
        await desk.note(code, form.get("note", ""), user.name)
    except InvalidValue as error:
        frame = Frame(services, user, _any_study(services), "")
        return await _story(frame, desk, code, {"note": error.sentence})
    return RedirectResponse(f"/admin/participants/{code.upper()}#notes", 303)


async def _alter(act: str, code: str, form: Mapping[str, str], given: Any) -> Response:
    services, user, desk = given
    lives = LifeDesk(services.database)
    move = lives.exclude if act == "exclude" else lives.reinstate
    try:
        await move(code, form.get("reason", ""), user.name)
    except InvalidValue as error:
        frame = Frame(services, user, _any_study(services), "")
        return await _story(frame, desk, code, {"reason": error.sentence})
    return RedirectResponse(f"/admin/participants/{code.upper()}", 303)


async def _story(frame: Frame, desk: Any, code: str, problems: Mapping[str, str]) -> Response:
    story: dict[str, Any]
    async with frame.services.database.reading() as session:
        person = await find_by_code(session, code)
        study = await read_version(session, person.study_version_id)
        trials = await list_trials(session, person.id)
        story = {
            "changes": await list_changes(session, person.id),
            "answers": await list_answers(session, person.id),
            "events": await count_events(session, person.id),
            "claims": await list_claims(session, person.id),
            "notes": await list_notes(session, person.id),
        }
    for trial in trials:
        ended = trial["kind"] == "trial" and trial["status"] != "open"
        trial["flags"] = flag_trial(study.exclusion, trial) if ended else []
    played = [t for t in trials if t["kind"] == "trial" and t["status"] != "open"]
    preview = await desk.preview(study, code)
    shown = frame.services.participants.studies.get(person.study_id, study)
    values = story | {
        "person": _row(person, study),
        "version": study.config_hash,
        "trials": trials,
        "flags": flag_participant(study.exclusion, played),
        "labels": _labels(study),
        "steps": _steps(study, person, story["answers"], trials),
        "preview": preview,
        "problems": problems,
    }
    page = Frame(frame.services, frame.user, shown, "")
    return page.page("admin-participant.html", values, 422 if problems else 200)


def _steps(
    study: Study, person: ParticipantRecord, answers: list[Any], trials: list[Any]
) -> list[dict[str, Any]]:
    """Each step with when it was shown and when it was left, as far as is known."""
    sent: dict[str, tuple[datetime | None, datetime]] = {
        a["step"]: (a["shown_at"], a["answered_at"]) for a in answers
    }
    for trial in trials:
        sent[trial["step"]] = (trial["opened_at"], trial["ended_at"])
    steps = study.plan.steps
    at = steps.index(person.progress.step) if person.progress.step in steps else -1
    return [
        {
            "name": step,
            "shown": sent.get(step, (None, None))[0] or (person.step_shown_at if k == at else None),
            "left": sent.get(step, (None, None))[1],
            "state": "done" if k < at or step == "debrief" == person.progress.step else "now",
        }
        for k, step in enumerate(steps)
        if k <= at
    ]


def _labels(study: Study) -> dict[str, str]:
    return {item.name: item.label for one in study.all_instruments for item in one.items}


def _any_study(services: Any) -> Study:
    studies: Mapping[str, Study] = services.participants.studies
    return next(iter(studies.values()))


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


def _row(record: ParticipantRecord, study: Study) -> dict[str, Any]:
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
