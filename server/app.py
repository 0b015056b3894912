"""`create_app(settings, studies)`: the whole server. Nothing happens when this is imported."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import AsyncIterator, Mapping, Sequence
from typing import Any

from fastapi import FastAPI
from fastapi.exceptions import RequestValidationError
from prometheus_client import CollectorRegistry
from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.requests import HTTPConnection, Request
from starlette.responses import Response
from starlette.routing import WebSocketRoute

from server.api import description
from server.dashboard.sockets import staff_sockets
from server.dashboard.watch import LiveWatch
from server.deps import Services, find_account, require_expert, require_staff
from server.desks.audit import AuditDesk
from server.desks.bots import BotDesk
from server.desks.data import DataDesk
from server.desks.learning import StoredLearningDesk
from server.desks.lives import LifeDesk
from server.desks.participants import ParticipantDesk
from server.desks.policies import PolicyDesk
from server.desks.staff import AdminDesk
from server.desks.stories import StoryDesk
from server.desks.trials import StoredTrialDesk
from server.kernel_cache import kernel_folder
from server.live.compiling import prepare_kernels
from server.live.endpoint import LiveEndpoint
from server.live.hall import Hall
from server.live.learning.endpoint import ExpertEndpoint
from server.live.learning.runs import LearningRuns
from server.live.learning.trainer import PoolTrainer
from server.locations import web_root
from server.metrics import ServerFigures
from server.pages import (
    admin,
    admin_data,
    admin_live,
    admin_people,
    admin_story,
    admin_study,
    expert,
    participant,
    policies,
    service,
    staff,
    worker,
)
from server.pages.errors import answer_error
from server.pages.rendering import CachedFiles, Renderer
from server.security import Guard, same_origin
from server.settings import Settings
from server.signin import SignIns
from server.store.engine import Database, StorageAway, serve_alone
from server.store.schema import check_schema
from server.tokens import mask_server_logs
from server.worker_links import WorkerLinks
from study.config import Study
from study.errors import NotAllowedLive, StudyError

SWEEP_EVERY_S = 60.0
log = logging.getLogger("varil.server")


def create_app(settings: Settings, studies: Sequence[Study]) -> FastAPI:
    """The app for these studies. The database is touched when the app starts, not here.

    Raises `NotAllowedLive` if the time scale is not 1 and a study recruits live participants.
    """
    for study in studies:
        if study.recruiting == "live" and settings.time_scale != 1.0:
            raise NotAllowedLive(f"a time scale of {settings.time_scale:g}")
    services = _build_services(settings, studies)
    app = FastAPI(
        title="VARIL", docs_url=None, redoc_url=None, openapi_url=None, lifespan=_lifespan
    )
    app.state.services = services
    for pages in (service, participant, staff, expert, worker):
        app.include_router(pages.router)
    for pages in (admin, admin_people, admin_story, admin_live, admin_data, admin_study, policies):
        app.include_router(pages.router)
    for router in (*description.ROUTERS, description.router):
        app.include_router(router)
    app.state.hall = _build_hall(services)
    app.state.admin_desk = AdminDesk(
        services.database, services.policies, LiveWatch(app.state.hall), settings.time_scale
    )
    app.state.runs = _build_runs(services, app.state.hall)
    app.router.routes += _live_routes(services, app.state.hall, app.state.runs)
    app.mount("/static", CachedFiles(directory=web_root() / "static", check_dir=False))

    async def answer(request: Request, error: Exception, reference: str = "") -> Response:
        return await answer_error(services.renderer, request, error, reference)

    app.add_exception_handler(StudyError, answer)
    app.add_exception_handler(HTTPException, answer)
    app.add_exception_handler(RequestValidationError, answer)
    app.add_middleware(Guard, error_page=answer, allowed_origins=tuple(settings.allowed_origins))
    return app


def _build_hall(services: Services) -> Hall:
    hall = Hall(services.trials, lambda: prepare_kernels(kernel_folder()))
    services.metrics.register(ServerFigures(hall))
    return hall


def _build_runs(services: Services, hall: Hall) -> LearningRuns:
    return LearningRuns(services.learning, hall, PoolTrainer(), services.settings.time_scale)


def _live_routes(services: Services, hall: Hall, runs: LearningRuns) -> list[WebSocketRoute]:
    origins = tuple(services.settings.allowed_origins)

    def is_ours(headers: Headers) -> bool:
        return same_origin(headers, origins)

    async def identify(scope: Mapping[str, Any]) -> str:
        user = await find_account(services, HTTPConnection(dict(scope)).cookies)
        return (await require_expert(await require_staff(user))).name

    return [
        WebSocketRoute("/p/{token}/live", LiveEndpoint(hall, is_ours)),
        WebSocketRoute("/w/{token}/live", LiveEndpoint(runs, is_ours, "/w")),
        WebSocketRoute("/expert/runs/{run}/live", ExpertEndpoint(runs, is_ours, identify)),
        *staff_sockets(services, hall, is_ours),
    ]


def _build_services(settings: Settings, studies: Sequence[Study]) -> Services:
    key = settings.read_secret_key()
    database = Database(settings.database)
    known = {study.study_id: study for study in studies}
    return Services(
        settings=settings,
        database=database,
        participants=ParticipantDesk(database, known, key),
        trials=StoredTrialDesk(database, settings.time_scale),
        learning=StoredLearningDesk(database),
        worker_links=WorkerLinks(key),
        policies=PolicyDesk(database, known),
        bots=BotDesk(database, known, key),
        lives=LifeDesk(database),
        stories=StoryDesk(database),
        data=DataDesk(database),
        audit=AuditDesk(database),
        sign_ins=SignIns(key),
        renderer=Renderer(web_root()),
        metrics=CollectorRegistry(),
    )


@contextlib.asynccontextmanager
async def _lifespan(app: FastAPI) -> AsyncIterator[None]:
    """Refuse a database in use or of another version; then run until told to stop."""
    services: Services = app.state.services
    hall: Hall = app.state.hall
    mask_server_logs()
    try:
        async with serve_alone(services.database):
            await check_schema(services.database)
            await services.participants.register_studies()
            await services.policies.register_shipped()
            await hall.start()
            sweeper = asyncio.create_task(_sweep_forever(services.participants))
            try:
                yield
            finally:
                sweeper.cancel()
                await asyncio.gather(sweeper, return_exceptions=True)
                await hall.stop()
                await app.state.runs.stop()
    finally:
        await services.database.close()


async def _sweep_forever(desk: ParticipantDesk) -> None:
    """End idle participations once a minute, also after a storage failure."""
    while True:
        try:
            await desk.sweep()
        except StorageAway:
            log.warning("idle participants were not looked for: the storage is away")
        await asyncio.sleep(SWEEP_EVERY_S)
