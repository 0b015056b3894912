"""Guards who is a simulated participant: those issued as such, whatever a request says."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from fastapi import FastAPI
from sqlalchemy import select
from starlette.testclient import TestClient

from server.store.tables import Participant
from study.config import Study

SignIn = Callable[[str], TestClient]
CLAIMS = {"mode": "bot", "is_bot": "true", "bot": "1", "lock_step": "true", "time_scale": "4"}
HEADERS = {f"X-{name.replace('_', '-')}": value for name, value in CLAIMS.items()}


def people(client: TestClient, app: FastAPI) -> list[tuple[str, bool]]:
    """Mode and mark of everybody, oldest first."""

    async def read() -> list[tuple[str, bool]]:
        async with app.state.services.database.reading() as session:
            rows = await session.scalars(select(Participant).order_by(Participant.id))
            return [(row.mode, row.is_bot) for row in rows]

    assert client.portal is not None
    return client.portal.call(read)


def issue(client: TestClient, count: int = 1) -> list[dict[str, str]]:
    answer = client.post("/api/v1/studies/demo/bots", json={"count": count})
    assert answer.status_code == 201, answer.text
    bots: list[dict[str, str]] = answer.json()["bots"]
    return bots


def test_an_administrator_is_issued_bots(
    sign_in_as: SignIn, app: FastAPI, audit: Callable[[], list[tuple[str, str, str]]]
) -> None:
    """Each with an address of its own that shows the first step; written down."""
    admin = sign_in_as("admin")
    bots = issue(admin, 3)
    assert len({bot["address"] for bot in bots}) == len({bot["code"] for bot in bots}) == 3
    assert people(admin, app) == [("bot", True)] * 3
    assert "Information and consent" in admin.get(bots[0]["address"]).text
    assert ("the-admin", "bots issued", "demo: 3") in audit()


@pytest.mark.parametrize("role", ["", "expert"])
def test_nobody_else_is_issued_any(
    client: TestClient, sign_in_as: SignIn, app: FastAPI, role: str
) -> None:
    if role:
        sign_in_as(role)
    for path in ("bots", "bots/time-out"):
        answer = client.post(f"/api/v1/studies/demo/{path}", json={"count": 1, "codes": ["P-1"]})
        assert answer.status_code == (403 if role else 401)
        assert answer.headers["content-type"] == "application/problem+json"
    assert people(client, app) == []


@pytest.mark.parametrize(
    "body", [{}, {"count": 0}, {"count": 1001}, {"count": "many"}, {"count": 1, "mode": "live"}, []]
)
def test_an_order_that_cannot_be_meant_issues_nobody(
    sign_in_as: SignIn, app: FastAPI, body: Any
) -> None:
    admin = sign_in_as("admin")
    answer = admin.post("/api/v1/studies/demo/bots", json=body)
    assert answer.status_code == 422
    assert people(admin, app) == []


def test_no_request_makes_a_participant_a_bot(
    walker: Any, client: TestClient, app: FastAPI, study: Study
) -> None:
    """Forms, query parameters and headers that claim it, at joining and at every step."""
    client.post("/s/demo", data=CLAIMS, params=CLAIMS, headers=HEADERS)
    client.get("/s/demo", params=CLAIMS, headers=HEADERS)
    for step in study.plan.steps:
        walker.walk_to(step)
        client.get(walker.address, params=CLAIMS, headers=HEADERS)
        for method in ("POST", "PUT", "PATCH"):
            client.request(
                method, f"{walker.address}/{step}", data=CLAIMS, params=CLAIMS, headers=HEADERS
            )
        client.request("PATCH", walker.address, json=CLAIMS)
    assert set(people(client, app)) == {(study.recruiting, False)}


def test_only_bots_are_timed_out_by_hand(walker: Any, sign_in_as: SignIn, app: FastAPI) -> None:
    """One who is none among them: refused, and nobody is ended."""
    admin = sign_in_as("admin")
    bot = issue(admin)[0]["code"]
    people_page = admin.get("/api/v1/participants").json()["items"]
    person = next(one["code"] for one in people_page if not one["is_bot"])
    path = "/api/v1/studies/demo/bots/time-out"
    assert admin.post(path, json={"codes": [bot, person]}).status_code == 400
    assert admin.get(f"/api/v1/participants/{bot}").json()["status"] == "joined"
    assert admin.post(path, json={"codes": [bot]}).json() == {"ended": 1}
    told = admin.get(f"/api/v1/participants/{bot}").json()
    assert told["status"] == "timed-out"
    assert [change["now"] for change in told["changes"]] == ["joined", "timed-out"]
