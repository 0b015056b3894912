"""Participants' pages: the landing, the one address that shows the current step, and its forms."""

from __future__ import annotations

from fastapi import APIRouter, Request
from starlette.responses import RedirectResponse, Response

from server.deps import DeskDep, FormDep, RendererDep
from server.pages.views import Typed, View, view_step, view_withdrawal
from server.tokens import make_nonce
from study.errors import AnswerError

router = APIRouter(include_in_schema=False)


@router.get("/s/{study_id}")
async def show_landing(
    study_id: str, request: Request, desk: DeskDep, renderer: RendererDep
) -> Response:
    """What the study is, with a button. Stores nothing, so link previews take no place."""
    study = desk.find_study(study_id)
    query = request.query_params
    panel = {name: query[name][:200] for name in study.panel.parameters if name in query}
    return renderer.page("landing.html", {"study": study, "panel": panel, "nonce": make_nonce()})


@router.post("/s/{study_id}")
async def join(study_id: str, form: FormDep, desk: DeskDep) -> Response:
    """Make the participant and lead to the personal address."""
    token = await desk.join(study_id, form.get("join", ""), form)
    return _go(f"/p/{token}")


@router.get("/p/{token}")
async def show_step(token: str, desk: DeskDep, renderer: RendererDep) -> Response:
    """The current step, whatever it is."""
    visit = await desk.visit(token)
    return _render(renderer, view_step(visit, f"/p/{token}"))


@router.get("/p/{token}/withdraw")
async def ask_to_withdraw(token: str, desk: DeskDep, renderer: RendererDep) -> Response:
    """The page that asks before withdrawing; one who has withdrawn is led to the end."""
    visit = await desk.look_up(token)
    if visit.participant.progress.outcome == "withdrawn":
        return _go(f"/p/{token}")
    return _render(renderer, view_withdrawal(visit, f"/p/{token}"))


@router.post("/p/{token}/withdraw")
async def withdraw(token: str, desk: DeskDep) -> Response:
    """End the participation."""
    await desk.withdraw(token)
    return _go(f"/p/{token}")


@router.get("/p/{token}/{step}")
async def lead_back(token: str, step: str, desk: DeskDep) -> Response:
    """A step's address opened by hand, or reloaded after a refused form: the one page."""
    del step
    await desk.look_up(token)
    return _go(f"/p/{token}")


@router.post("/p/{token}/{step}")
async def send_step(
    token: str, step: str, form: FormDep, desk: DeskDep, renderer: RendererDep
) -> Response:
    """Store a step's form and lead on; unfit answers bring the form back as it was typed."""
    try:
        await desk.submit(token, step, form)
    except AnswerError as error:
        visit = await desk.look_up(token)
        return _render(renderer, view_step(visit, f"/p/{token}", Typed(form, error.problems)), 422)
    return _go(f"/p/{token}")


def _render(renderer: RendererDep, view: View, status: int = 200) -> Response:
    return renderer.page(view.template, view.values, status)


def _go(address: str) -> Response:
    return RedirectResponse(address, 303)
