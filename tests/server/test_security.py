"""Guards what every answer carries and what no request may do."""

from __future__ import annotations

import io
import logging
from collections.abc import Iterator
from typing import Any

import pytest
from fastapi import FastAPI
from fastapi.routing import APIRoute
from pydantic import SecretStr
from starlette.datastructures import Headers
from starlette.testclient import TestClient
from starlette.websockets import WebSocketDisconnect

from server.app import create_app
from server.security import BODY_LIMIT_BYTES, same_origin
from server.settings import Settings
from server.store.engine import StorageAway
from server.tokens import derive_token, looks_like_token, mask_server_logs, mask_tokens
from study.config import Study

ADDRESSES = (
    "/",
    "/s/demo",
    "/s/nope",
    "/p/unknown",
    "/login",
    "/admin",
    "/admin/export",
    "/admin/policies",
    "/admin/policies/0",
    "/expert",
    "/expert/runs",
    "/expert/runs/0/dataset.csv",
    "/w/unknown",
    "/healthz",
    "/readyz",
    "/metrics",
    "/nothing/here",
    "/static/js/form.js",
    "/static/none.js",
)


def check_headers(headers: Any) -> None:
    policy = headers["content-security-policy"]
    for part in (
        "default-src 'self'",
        "script-src 'self'",
        "frame-ancestors 'none'",
        "base-uri 'none'",
        "form-action 'self'",
        "require-trusted-types-for 'script'",
    ):
        assert part in policy
    assert "unsafe" not in policy
    assert headers["referrer-policy"] == "no-referrer"
    assert headers["x-content-type-options"] == "nosniff"
    assert "camera=()" in headers["permissions-policy"]


@pytest.mark.parametrize("method", ["GET", "POST", "PUT", "OPTIONS"])
@pytest.mark.parametrize("address", ADDRESSES)
def test_every_answer_carries_the_headers(client: TestClient, address: str, method: str) -> None:
    answer = client.request(method, address)
    assert answer.status_code < 500
    check_headers(answer.headers)
    if not address.startswith("/static/"):
        assert answer.headers["cache-control"] == "no-store"


def test_static_files_are_kept_only_under_their_hash(client: TestClient) -> None:
    assert client.get("/static/js/form.js").headers["cache-control"] == "no-cache"
    hashed = client.get("/static/js/form.js?v=1")
    assert "immutable" in hashed.headers["cache-control"]
    assert "immutable" not in client.get("/static/none.js?v=1").headers["cache-control"]


def test_no_page_runs_inline_code_or_loads_from_elsewhere(walker: Any) -> None:
    for step in ("consent", "browser-check", "practice", "explanation-1", "debrief"):
        walker.walk_to(step)
        page = walker.page().text
        assert "style=" not in page
        assert "<script>" not in page
        assert " on" + "click" not in page
        assert "//" not in page.replace("</", "")


def unsafe_addresses(app: FastAPI) -> list[str]:
    inner = [
        route
        for outer in app.routes
        for route in getattr(getattr(outer, "original_router", None), "routes", [outer])
    ]
    return [
        route.path
        for route in inner
        if isinstance(route, APIRoute) and route.methods - {"GET", "HEAD"}
    ]


def fill(address: str, token: str) -> str:
    """The address of a route with something in each of its places."""
    return address.format(
        study_id="demo",
        token=token,
        step="withdraw",
        run_id="0" * 32,
        iteration=1,
        sha256="0" * 64,
        code="P-NOBODY22",
        trial="0" * 32,
        trial_id="0" * 32,
    )


def test_no_unsafe_request_from_another_site_is_accepted(app: FastAPI, walker: Any) -> None:
    addresses = unsafe_addresses(app)
    assert len(addresses) >= 10, addresses
    foreign = (
        {"origin": "https://evil.example"},
        {"origin": "null"},
        {"sec-fetch-site": "cross-site"},
        {"sec-fetch-site": "same-site", "origin": "http://testserver"},
        {"sec-fetch-site": "same-origin", "origin": "https://evil.example"},
        {"origin": "http://testserver.evil.example"},
        {"origin": "http://testserver:8000"},
    )
    for address in addresses:
        path = fill(address, walker.token)
        for headers in foreign:
            answer = walker.client.post(path, headers=headers)
            assert answer.status_code == 403, (path, headers)
    assert walker.step() == "consent"


@pytest.mark.parametrize(
    "headers",
    [
        {},
        {"origin": "http://testserver", "host": "testserver"},
        {"sec-fetch-site": "same-origin", "origin": "null"},
        {"sec-fetch-site": "none"},
        {"origin": "https://study.example", "host": "10.0.0.5:8000"},
    ],
)
def test_our_own_pages_are_recognised(headers: dict[str, str]) -> None:
    assert same_origin(Headers(headers), ("https://study.example",))


def test_a_socket_from_another_site_is_not_accepted(client: TestClient, walker: Any) -> None:
    walker.walk_to("practice")
    foreign = {"origin": "https://evil.example"}
    with (
        pytest.raises(WebSocketDisconnect) as caught,
        client.websocket_connect(f"{walker.address}/live", headers=foreign),
    ):
        pass
    assert caught.value.code == 4403


@pytest.mark.parametrize("declared", [True, False])
def test_a_request_larger_than_any_form_is_refused(walker: Any, declared: bool) -> None:
    body = b"remarks=" + b"x" * BODY_LIMIT_BYTES
    pieces = (body[k : k + 1000] for k in range(0, len(body), 1000))
    answer = walker.client.post(
        f"{walker.address}/consent",
        content=body if declared else pieces,
        headers={"content-type": "application/x-www-form-urlencoded"},
    )
    assert answer.status_code == 413
    check_headers(answer.headers)


def test_a_mistake_of_ours_shows_a_reference_and_nothing_else(
    client: TestClient, app: FastAPI, monkeypatch: pytest.MonkeyPatch, caplog: Any
) -> None:
    async def fail(*_: object) -> None:
        raise ZeroDivisionError("secret detail")

    monkeypatch.setattr(type(app.state.services.participants), "look_up", fail)
    monkeypatch.setattr(type(app.state.services.participants), "visit", fail)
    with caplog.at_level(logging.ERROR, logger="varil.server"):
        answer = client.get("/p/" + "a" * 32)
    assert answer.status_code == 500
    assert "secret detail" not in answer.text
    reference = caplog.records[-1].getMessage().split()[-1]
    assert reference in answer.text
    check_headers(answer.headers)


def test_storage_that_is_away_is_told_as_such(
    client: TestClient, app: FastAPI, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def fail(*_: object) -> None:
        raise StorageAway

    monkeypatch.setattr(type(app.state.services.participants), "visit", fail)
    monkeypatch.setattr(type(app.state.services.database), "ping", fail)
    page = client.get("/p/" + "a" * 32)
    assert (page.status_code, "try again" in page.text) == (503, True)
    ready = client.get("/readyz")
    assert ready.status_code == 503
    assert "storage" in ready.json()["error"]
    assert client.get("/healthz").json() == {"status": "ok"}


def test_metrics_are_for_this_machine_or_a_token(settings: Settings, study: Study) -> None:
    """A caller behind a proxy on this machine looks local, but asks for a public name."""
    guarded = settings.model_copy(update={"metrics_token": SecretStr("for-the-scraper")})
    app = create_app(guarded, (study,))
    here = TestClient(app, base_url="http://127.0.0.1:8000", client=("127.0.0.1", 5000))
    proxied = TestClient(app, base_url="http://study.example", client=("127.0.0.1", 5000))
    assert here.get("/metrics").status_code == 200
    assert proxied.get("/metrics").status_code == 403
    for token, status in (("for-the-scraper", 200), ("guessed", 403)):
        headers = {"Authorization": f"Bearer {token}"}
        assert proxied.get("/metrics", headers=headers).status_code == status


def test_tokens_are_long_url_safe_and_keyed() -> None:
    first = derive_token(b"k" * 32, "demo", "")
    assert looks_like_token(first)
    assert first != derive_token(b"k" * 32, "demo", "")
    nonce = "A" * 22
    assert derive_token(b"k" * 32, "demo", nonce) == derive_token(b"k" * 32, "demo", nonce)
    others = {derive_token(b"o" * 32, "demo", nonce), derive_token(b"k" * 32, "other", nonce)}
    assert len(others | {derive_token(b"k" * 32, "demo", nonce)}) == 3


@pytest.mark.parametrize(
    "line",
    [
        '127.0.0.1 - "GET /p/SECRET HTTP/1.1" 200',
        '"WebSocket /p/SECRET/live" [accepted]',
        "/w/SECRET?x=1",
        "GET http://h/p/SECRET/questionnaire-1",
    ],
)
def test_tokens_are_masked_wherever_an_address_is_logged(line: str) -> None:
    assert "SECRET" not in mask_tokens(line)


@pytest.fixture
def log_text() -> Iterator[io.StringIO]:
    """Everything that a handler of the root logger writes, once the mask is on."""
    written = io.StringIO()
    handler = logging.StreamHandler(written)
    root = logging.getLogger()
    level = root.level
    root.addHandler(handler)
    root.setLevel(logging.DEBUG)
    mask_server_logs()
    yield written
    root.removeHandler(handler)
    root.setLevel(level)


def test_a_traceback_is_masked_too(log_text: io.StringIO) -> None:
    """Guards the handlers: a logger's filter would see neither children nor exceptions."""
    try:
        raise ValueError("bad address /p/SECRET/live")
    except ValueError:
        logging.getLogger("server.live.anything").exception("at %s", "/p/SECRET")
    assert "bad address /p/***" in log_text.getvalue()
    assert "SECRET" not in log_text.getvalue()


def test_no_log_line_of_a_walk_holds_the_token(walker: Any, log_text: io.StringIO) -> None:
    logging.getLogger("uvicorn.access").info('"%s %s" %d', "GET", walker.address, 200)
    walker.walk_to("debrief")
    walker.send("comments", {"remarks": "again"})
    assert "/p/***" in log_text.getvalue()
    assert walker.token not in log_text.getvalue()
