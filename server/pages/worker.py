"""The page of a person who works in a learning run."""

from __future__ import annotations

from fastapi import APIRouter
from starlette.responses import Response

from server.deps import ServicesDep

router = APIRouter(include_in_schema=False)


@router.get("/w/{token}")
async def show_work(token: str, services: ServicesDep) -> Response:
    """The warehouse while the run is open, a word of thanks afterwards; raises UnknownToken."""
    run = await services.learning.find_worker_run(token)
    values = {
        "address": f"/w/{token}",
        "run": {"short_id": run.short_id, "scale": run.scale},
    }
    template = "worker.html" if run.status == "open" else "worker-ended.html"
    return services.renderer.page(template, values)
