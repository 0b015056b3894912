"""What handlers may ask for in their signatures."""

from __future__ import annotations

import secrets
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, cast

from fastapi import Depends, Request
from prometheus_client import CollectorRegistry

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
from server.pages.rendering import Renderer
from server.problems import RoleNeeded, SignInNeeded
from server.settings import Settings
from server.signin import COOKIE, SignIns
from server.store.engine import Database
from server.store.users import StaffRecord, read_user
from server.worker_links import WorkerLinks


@dataclass(frozen=True)
class Services:
    """Everything that one app is made of; built by `create_app`, handed to handlers."""

    settings: Settings
    database: Database
    participants: ParticipantDesk
    trials: StoredTrialDesk
    learning: StoredLearningDesk
    worker_links: WorkerLinks
    policies: PolicyDesk
    bots: BotDesk
    lives: LifeDesk
    stories: StoryDesk
    data: DataDesk
    audit: AuditDesk
    sign_ins: SignIns
    renderer: Renderer
    metrics: CollectorRegistry


def get_services(request: Request) -> Services:
    """The app's services."""
    return cast("Services", request.app.state.services)


ServicesDep = Annotated[Services, Depends(get_services)]


def get_admin_desk(request: Request) -> AdminDesk:
    """The desk for administrators."""
    return cast("AdminDesk", request.app.state.admin_desk)


def get_desk(services: ServicesDep) -> ParticipantDesk:
    """The desk for participants."""
    return services.participants


def get_renderer(services: ServicesDep) -> Renderer:
    """The page renderer."""
    return services.renderer


async def read_form(request: Request) -> Mapping[str, str]:
    """The text fields of a sent form; of a field sent twice the last counts, files are ignored."""
    form = await request.form(max_files=0, max_fields=200)
    return {name: value for name, value in form.multi_items() if isinstance(value, str)}


@dataclass(frozen=True)
class Upload:
    """An uploaded file; empty if none was chosen."""

    file: bytes


async def read_upload(request: Request) -> Upload:
    """The file of the field `file`; the limit on a request's body keeps it small."""
    form = await request.form(max_files=1, max_fields=20)
    sent = form.get("file")
    return Upload(b"" if sent is None or isinstance(sent, str) else await sent.read())


async def find_staff(request: Request, services: ServicesDep) -> StaffRecord | None:
    """The signed-in account, if any; read anew each time, so a changed account counts at once."""
    return await find_account(services, request.cookies)


async def find_account(services: Services, cookies: Mapping[str, str]) -> StaffRecord | None:
    """The account that these cookies of a page or socket sign in, if any."""
    known = services.sign_ins.read(cookies.get(COOKIE, ""))
    if known is None:
        return None
    user_id, key = known
    async with services.database.reading() as session:
        user = await read_user(session, user_id)
    return user if user and secrets.compare_digest(user.session_key, key) else None


async def require_staff(user: Annotated[StaffRecord | None, Depends(find_staff)]) -> StaffRecord:
    """Any signed-in account; raises `SignInNeeded`."""
    if user is None:
        raise SignInNeeded
    return user


async def require_expert(user: Annotated[StaffRecord, Depends(require_staff)]) -> StaffRecord:
    """A signed-in expert or administrator; raises `SignInNeeded` or `RoleNeeded`."""
    if user.role not in ("expert", "admin"):
        raise RoleNeeded("expert")
    return user


async def require_admin(user: Annotated[StaffRecord, Depends(require_staff)]) -> StaffRecord:
    """A signed-in administrator; raises `SignInNeeded` or `RoleNeeded`."""
    if user.role != "admin":
        raise RoleNeeded("admin")
    return user


DeskDep = Annotated[ParticipantDesk, Depends(get_desk)]
RendererDep = Annotated[Renderer, Depends(get_renderer)]
FormDep = Annotated[Mapping[str, str], Depends(read_form)]
UploadDep = Annotated[Upload, Depends(read_upload)]
StaffDep = Annotated[StaffRecord, Depends(require_staff)]
ExpertDep = Annotated[StaffRecord, Depends(require_expert)]
AdminDep = Annotated[StaffRecord, Depends(require_admin)]
AdminDeskDep = Annotated[AdminDesk, Depends(get_admin_desk)]
