"""Experts' pages: the list of learning runs, starting one, and the page of one run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from fastapi import APIRouter, Path, Request
from starlette.responses import RedirectResponse, Response, StreamingResponse

from server.deps import ExpertDep, FormDep, ServicesDep
from server.pages.rendering import moment
from server.pages.run_form import FIELDS, FURTHER_FIELDS, LABELS, fresh_values, read_run_form
from server.store.learning import RunRecord
from server.store.users import StaffRecord
from server.worker_links import COOKIE, KEPT_S
from study.errors import AnswerError
from study.learning.settings import MOST_ITERATIONS

router = APIRouter(prefix="/expert", include_in_schema=False)
PAGE_ROWS = 50
Iteration = Annotated[int, Path(ge=0, le=MOST_ITERATIONS)]


@router.get("")
async def show_runs(services: ServicesDep, user: ExpertDep, page: int = 1) -> Response:
    """One page of learning runs, newest first, and the form that starts another."""
    return await _list_page(services, user, page, fresh_values(), {})


@router.post("/runs")
async def start_run(
    request: Request, services: ServicesDep, user: ExpertDep, form: FormDep
) -> Response:
    """Start a run and lead to its page; unfit settings bring the form back as it was typed."""
    try:
        wanted = read_run_form(form)
    except AnswerError as error:
        typed = fresh_values() | dict(form)
        return await _list_page(services, user, 1, typed, error.problems)
    run_id, token = await services.learning.create_run(wanted, user.name)
    return _lead_to_run(request, services, run_id, token)


@router.get("/runs")
async def lead_to_list(user: ExpertDep) -> Response:
    """The address of the sent form, opened by hand or loaded again."""
    del user
    return RedirectResponse("/expert", 303)


@router.get("/runs/{run_id}")
async def show_run(
    run_id: str, request: Request, services: ServicesDep, user: ExpertDep
) -> Response:
    """The page on which the expert works. The worker's link is shown once after it was made."""
    run = await services.learning.read_run_summary(run_id)
    cookie = request.cookies.get(COOKIE, "")
    token = services.worker_links.open(run.id, cookie)
    values = {
        "user": user,
        "run": _run_values(run),
        "worker_link": f"{request.url.scheme}://{request.url.netloc}/w/{token}" if token else None,
        "address": f"/expert/runs/{run.id}",
    }
    answer = services.renderer.page("expert-run.html", values)
    if cookie:
        answer.delete_cookie(COOKIE, path=f"/expert/runs/{run.id}", httponly=True, samesite="lax")
    return answer


@router.post("/runs/{run_id}/worker-link")
async def renew_worker_link(
    run_id: str, request: Request, services: ServicesDep, user: ExpertDep
) -> Response:
    """Make the worker's link anew; the former one leads nowhere from now on."""
    token = await services.learning.renew_worker_link(run_id, user.name)
    return _lead_to_run(request, services, run_id, token)


@router.post("/runs/{run_id}/stop")
async def stop_run(run_id: str, services: ServicesDep, user: ExpertDep) -> Response:
    """End the run before its time; what is stored stays."""
    await services.learning.stop_run(run_id, user.name)
    return RedirectResponse(f"/expert/runs/{run_id}", 303)


@router.get("/runs/{run_id}/dataset.csv")
async def download_dataset(run_id: str, services: ServicesDep, user: ExpertDep) -> Response:
    """The stored pairs, written while they are sent."""
    del user
    run = await services.learning.read_run_summary(run_id)
    return StreamingResponse(
        services.learning.stream_dataset(run.id),
        media_type="text/csv",
        headers=_as_file(f"run-{run.short_id}-dataset.csv"),
    )


@router.get("/runs/{run_id}/policies/latest.json")
async def download_latest_version(run_id: str, services: ServicesDep, user: ExpertDep) -> Response:
    """The newest policy file that the run has."""
    del user
    iteration, document = await services.learning.read_latest_version(run_id)
    return _policy_file(run_id, iteration, document)


@router.get("/runs/{run_id}/policies/{iteration}.json")
async def download_version(
    run_id: str, iteration: Iteration, services: ServicesDep, user: ExpertDep
) -> Response:
    """The policy file after so many iterations."""
    del user
    document = await services.learning.read_version(run_id, iteration)
    return _policy_file(run_id, iteration, document)


async def _list_page(
    services: ServicesDep,
    user: StaffRecord,
    page: int,
    typed: Mapping[str, str],
    problems: Mapping[str, str],
) -> Response:
    page = max(1, min(page, 1_000_000))
    records, total = await services.learning.list_runs(
        offset=(page - 1) * PAGE_ROWS, limit=PAGE_ROWS
    )
    values = {
        "user": user,
        "runs": [_run_values(record) for record in records],
        "total": total,
        "page": page,
        "pages": max(1, -(-total // PAGE_ROWS)),
        "fields": FIELDS,
        "further_fields": FURTHER_FIELDS,
        "labels": LABELS,
        "values": typed,
        "problems": problems,
    }
    return services.renderer.page("expert.html", values, 422 if problems else 200)


def _lead_to_run(
    request: Request, services: ServicesDep, run_id: str, token: str | None
) -> Response:
    answer = RedirectResponse(f"/expert/runs/{run_id}", 303)
    if token is not None:
        answer.set_cookie(
            COOKIE,
            services.worker_links.seal(run_id, token),
            max_age=KEPT_S,
            path=f"/expert/runs/{run_id}",
            httponly=True,
            samesite="lax",
            secure=request.url.scheme == "https",
        )
    return answer


def _run_values(run: RunRecord) -> dict[str, Any]:
    return {
        "id": run.id,
        "short_id": run.short_id,
        "scale": run.scale,
        "seed": run.seed,
        "status": run.status,
        "worker": run.worker,
        "iteration": run.iteration,
        "iterations": run.settings["iterations"],
        "pairs": run.pairs,
        "created_at": moment(run.created_at),
        "created_by": run.created_by,
        "ended_at": moment(run.ended_at),
        "settings": {k: v for k, v in run.settings.items() if k != "thresholds"},
    }


def _policy_file(run_id: str, iteration: int, document: str) -> Response:
    headers = _as_file(f"run-{run_id[:6]}-{iteration:03}.json")
    return Response(document, media_type="application/json", headers=headers)


def _as_file(name: str) -> dict[str, str]:
    return {"Content-Disposition": f'attachment; filename="{name}"'}
