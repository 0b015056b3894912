"""Pages for machines, and the home page."""

from __future__ import annotations

import secrets

from fastapi import APIRouter, Request
from prometheus_client import CONTENT_TYPE_LATEST, generate_latest
from starlette.responses import JSONResponse, Response

from server.deps import RendererDep, ServicesDep
from server.problems import Refused
from server.store.schema import check_schema
from study.files.schema import schema_text

LOOPBACK = ("127.0.0.1", "::1", "localhost")
router = APIRouter(include_in_schema=False)


@router.get("/")
async def show_home(services: ServicesDep, renderer: RendererDep) -> Response:
    """What this server is; studies that recruit pilots are open to all."""
    pilots = [s for s in services.participants.studies.values() if s.recruiting == "pilot"]
    values = {"brand": "Studies with people and robots", "studies": pilots}
    return renderer.page("home.html", values)


@router.get("/study.schema.json")
async def give_schema() -> Response:
    """The JSON Schema of study files, for editors."""
    return Response(schema_text(), media_type="application/schema+json")


@router.get("/healthz")
async def tell_health() -> Response:
    """The process answers."""
    return JSONResponse({"status": "ok"})


@router.get("/readyz")
async def tell_readiness(services: ServicesDep) -> Response:
    """The database is reachable and has the current schema; otherwise 503 with the reason."""
    await services.database.ping()
    await check_schema(services.database)
    return JSONResponse({"status": "ready"})


@router.get("/metrics")
async def tell_metrics(request: Request, services: ServicesDep) -> Response:
    """Figures for Prometheus: for this machine, or with the configured bearer token."""
    if not (_is_local(request) or _has_token(request, services)):
        raise Refused(
            "metrics are for this machine only",
            next_step="Send the bearer token set as VARIL_METRICS_TOKEN.",
        )
    return Response(generate_latest(services.metrics), media_type=CONTENT_TYPE_LATEST)


def _is_local(request: Request) -> bool:
    """Asked from this machine for this machine: behind a proxy every caller looks local."""
    caller = request.client.host if request.client else ""
    return caller in LOOPBACK and request.url.hostname in LOOPBACK


def _has_token(request: Request, services: ServicesDep) -> bool:
    wanted = services.settings.metrics_token
    sent = request.headers.get("authorization", "").removeprefix("Bearer ")
    return wanted is not None and secrets.compare_digest(
        sent.encode(), wanted.get_secret_value().encode()
    )
