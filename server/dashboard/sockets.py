"""The sockets of the administrators' pages: who may open them and what they lead to."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from starlette.datastructures import Headers
from starlette.requests import HTTPConnection
from starlette.routing import WebSocketRoute

from server.dashboard.people import describe_people
from server.dashboard.watch import LiveWatch
from server.deps import Services, find_account, require_admin, require_staff
from server.live.hall import Hall
from server.live.outbox import SpectatorOutbox
from server.live.ports import OpenTrial
from server.live.replaying import ReplayTalk
from server.live.watching import PeopleTalk, SpectatorTalk, StaffEndpoint, StaffTalk, Who
from server.store.trials import read_trial

Scope = Mapping[str, Any]


def staff_sockets(
    services: Services, hall: Hall, is_ours: Callable[[Headers], bool]
) -> list[WebSocketRoute]:
    """Routes for administrators only."""
    watch = LiveWatch(hall)

    async def identify(scope: Scope) -> str:
        user = await find_account(services, HTTPConnection(dict(scope)).cookies)
        return (await require_admin(await require_staff(user))).name

    async def describe(study_id: str) -> Mapping[str, Any]:
        return await describe_people(services.database, watch, study_id)

    async def is_over(trial_id: str) -> bool:
        async with services.database.reading() as session:
            return (await read_trial(session, trial_id)).status != "open"

    async def recall(trial_id: str) -> OpenTrial:
        await hall.settle()
        return await services.trials.recall(trial_id)

    def begin_people(scope: Scope, outbox: SpectatorOutbox, who: Who) -> StaffTalk:
        study = HTTPConnection(dict(scope)).query_params.get("study", "")
        return PeopleTalk(outbox, who, study[:40], describe)

    def begin_watching(scope: Scope, outbox: SpectatorOutbox, who: Who) -> StaffTalk:
        return SpectatorTalk(outbox, who, hall, str(scope["path_params"]["trial"]), is_over)

    def begin_replay(scope: Scope, outbox: SpectatorOutbox, who: Who) -> StaffTalk:
        return ReplayTalk(outbox, who, str(scope["path_params"]["trial"]), recall)

    talks = {
        "/admin/live/socket": begin_people,
        "/admin/live/{trial}/socket": begin_watching,
        "/admin/replay/{trial}/socket": begin_replay,
    }
    return [
        WebSocketRoute(path, StaffEndpoint(is_ours, identify, begin))
        for path, begin in talks.items()
    ]
