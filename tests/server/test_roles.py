"""Guards who may open what, for every route there is: nobody, an expert, an administrator.

Routes are read off the app, so that a new one cannot be forgotten.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from fastapi import FastAPI
from fastapi.routing import APIRoute
from starlette.routing import BaseRoute, WebSocketRoute
from starlette.testclient import TestClient
from starlette.websockets import WebSocketDisconnect

from server.desks.learning import RunRequest
from study.learning.settings import LearningSettings

SignIn = Callable[[str], TestClient]
OPEN_TO_ALL = (
    "/", "/healthz", "/readyz", "/metrics", "/login", "/s/{study_id}", "/p/{token}",
    "/p/{token}/withdraw", "/p/{token}/return", "/p/{token}/{step}", "/w/{token}",
    "/study.schema.json",
)  # fmt: skip
FOR_EXPERTS = ("/expert", "/logout")
FOR_ADMINS = ("/admin", "/api")
HELLO = {"type": "hello", "version": 1, "client": "0123456789abcdef", "last_seq": 0}
PLACES = {
    "study_id": "demo",
    "token": "x" * 32,
    "step": "consent",
    "run_id": "0" * 32,
    "run": "0" * 32,
    "iteration": "0",
    "sha256": "0" * 64,
    "code": "P-NOBODY22",
    "trial": "0" * 32,
    "trial_id": "0" * 32,
}


def routes_of(app: FastAPI) -> Iterator[BaseRoute]:
    """All routes, those of routers that were included among them."""
    for outer in app.routes:
        yield from getattr(getattr(outer, "original_router", None), "routes", [outer])


def addresses(app: FastAPI) -> list[tuple[str, str]]:
    """Every method and path template of the app's pages."""
    return [
        (method, route.path)
        for route in routes_of(app)
        if isinstance(route, APIRoute)
        for method in sorted(route.methods - {"HEAD"})
    ]


def fill(path: str) -> str:
    """The path with something in each of its places; KeyError for a place unknown here."""
    return path.format(**PLACES)


def test_every_route_has_an_audience(app: FastAPI) -> None:
    """Whoever adds a route says here, or by its path, for whom it is."""
    known = addresses(app)
    assert len(known) > 25
    unsorted = [
        path
        for _, path in known
        if path not in OPEN_TO_ALL and not path.startswith((*FOR_EXPERTS, *FOR_ADMINS))
    ]
    assert unsorted == []


def test_nobody_opens_a_page_for_staff_without_signing_in(client: TestClient, app: FastAPI) -> None:
    for method, path in addresses(app):
        if path in OPEN_TO_ALL:
            continue
        answer = client.request(method, fill(path))
        if method == "GET" and not path.startswith("/api"):
            assert (answer.status_code, answer.headers["location"]) == (303, "/login"), path
        else:
            assert answer.status_code == 401, path


def test_an_expert_opens_nothing_of_administrators(sign_in_as: SignIn, app: FastAPI) -> None:
    expert = sign_in_as("expert")
    refused = [path for _, path in addresses(app) if path.startswith(FOR_ADMINS)]
    assert len(refused) >= 6
    for method, path in addresses(app):
        if path.startswith(FOR_ADMINS):
            answer = expert.request(method, fill(path))
            assert answer.status_code == 403, (method, path)
            assert "role “admin”" in answer.text


@pytest.mark.parametrize("role", ["expert", "admin"])
def test_both_roles_open_what_is_for_experts(sign_in_as: SignIn, app: FastAPI, role: str) -> None:
    """What is not there is not found; nothing is refused, and nothing fails."""
    client = sign_in_as(role)
    assert client.get("/expert").status_code == 200
    for method, path in addresses(app):
        if path.startswith("/expert/"):
            answer = client.request(method, fill(path))
            assert answer.status_code in (303, 404, 422), (method, path)


def test_experts_pages_hold_nothing_of_participants(
    sign_in_as: SignIn, app: FastAPI, walker: Any
) -> None:
    """Neither codes nor tokens, on any page that an expert can open; no link to the data either."""
    walker.walk_to("trial-1")
    walker.end_trial()
    desk, portal = app.state.services.participants, walker.client.portal
    code = portal.call(desk.look_up, walker.token).participant.code
    expert = sign_in_as("expert")
    request = RunRequest("small", LearningSettings(), "person")
    run_id, _ = portal.call(app.state.services.learning.create_run, request, "the-expert")
    for method, path in addresses(app):
        if path.startswith("/expert"):
            address = path.format(**PLACES | {"run_id": run_id})
            page = expert.request(method, address, follow_redirects=True).text
            assert code not in page
            assert walker.token not in page
            assert 'href="/admin' not in page


def code_of(walker: Any) -> str:
    desk, portal = walker.app.state.services.participants, walker.client.portal
    return str(portal.call(desk.look_up, walker.token).participant.code)


def hear_all(client: TestClient, path: str, *said: Any) -> list[dict[str, Any]]:
    """Everything that a socket says until it ends; after each answer it is told the next."""
    heard: list[dict[str, Any]] = []
    waiting = list(said or [HELLO])
    try:
        with client.websocket_connect(path) as line:
            while True:
                if waiting:
                    line.send_json(waiting.pop(0))
                heard.append(line.receive_json())
    except WebSocketDisconnect:
        return heard


def close_code(client: TestClient, path: str, headers: dict[str, str]) -> int:
    """How staff's socket ends after its page said hello."""
    try:
        with client.websocket_connect(path, headers=headers) as line:
            line.send_json(HELLO)
            while True:
                line.receive_text()
    except WebSocketDisconnect as ended:
        return ended.code


def test_sockets_for_administrators_refuse_everybody_else(
    client: TestClient, app: FastAPI, sign_in_as: SignIn
) -> None:
    """Who is not signed in, is an expert, or comes from another site hears nothing."""
    sockets = [r.path for r in routes_of(app) if isinstance(r, WebSocketRoute)]
    ours = [fill(path) for path in sockets if path.startswith("/admin")]
    assert len(ours) == 3
    for path in ours:
        assert close_code(client, path, {}) == 4403
    sign_in_as("expert")
    for path in ours:
        assert close_code(client, path, {}) == 4403
    sign_in_as("admin")
    for path in ours:
        assert close_code(client, path, {"origin": "https://evil.example"}) == 4403
        assert close_code(client, path, {"sec-fetch-site": "cross-site"}) == 4403
    heard = hear_all(client, "/admin/live/socket?study=demo", HELLO, {"type": "input"})
    assert [message["rows"] for message in heard] == [[]]
    for path in ours[1:]:
        assert close_code(client, path, {}) == 4401, "there is no such trial"


def test_sockets_tell_nothing_before_it_is_known_who_asks(
    client: TestClient, app: FastAPI, sign_in_as: SignIn, walker: Any
) -> None:
    """Neither nobody nor an expert hears more than why; a participant's trial is really there."""
    walker.walk_to("trial-1")
    trial, code = walker.end_trial(), code_of(walker)
    paths = ["/admin/live/socket?study=demo", f"/admin/live/{trial}/socket"]
    paths.append(f"/admin/replay/{trial}/socket")
    for sign_in in (lambda: None, lambda: sign_in_as("expert")):
        sign_in()
        for path in paths:
            heard = hear_all(client, path)
            assert [message["type"] for message in heard] == ["error"], path
            assert code not in str(heard)


def test_sockets_for_experts_refuse_everybody_else(
    client: TestClient, app: FastAPI, sign_in_as: SignIn
) -> None:
    """Who is not signed in, or comes from another site, hears no word of a run."""
    sockets = [r.path for r in routes_of(app) if isinstance(r, WebSocketRoute)]
    experts = [fill(path) for path in sockets if path.startswith("/expert")]
    assert len(experts) == 1
    assert close_code(client, experts[0], {}) == 4403
    sign_in_as("expert")
    assert close_code(client, experts[0], {"origin": "https://evil.example"}) == 4403
    assert close_code(client, experts[0], {}) == 4401, "there is no such run"
