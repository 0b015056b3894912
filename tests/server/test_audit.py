"""Guards the audit: whatever staff do, through any door, leaves one row that says who did what.

Doors are read off the app, so that a new one cannot be forgotten.
"""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass
from typing import Any

import pytest
from fastapi import FastAPI
from pwdlib import PasswordHash
from pwdlib.hashers.argon2 import Argon2Hasher
from starlette.testclient import TestClient

from server.dashboard.watch import LiveWatch
from server.desks.accounts import _decoy_hash, add_user
from server.desks.lives import LifeDesk
from server.pages.run_form import fresh_values
from server.policy_files import shipped_policy
from tests.server.bad_policies import make_policy
from tests.server.test_roles import OPEN_TO_ALL, addresses

PASSWORD = "a long enough password"
POLICY = make_policy("taught", "people", 1)
OF_PARTICIPANTS = ("/s/", "/p/", "/w/")
DOWNLOADS = (("GET", "/admin/export"), ("GET", "/api/v1/studies/{study_id}/export"))


@dataclass
class Office:
    """An administrator who is signed in, and somebody to do things to."""

    client: TestClient
    app: FastAPI
    code: str
    trial: str

    def send(self, path: str, **form: str) -> Any:
        return self.client.post(path, data=form)

    def send_json(self, path: str, body: Any) -> Any:
        return self.client.post(path, json=body)

    def start_run(self) -> str:
        """A learning run; returns its page."""
        answer = self.send("/expert/runs", **fresh_values())
        return str(answer.headers["location"])


Act = Callable[[Office], Any]


def _upload(office: Office) -> Any:
    file = ("p.json", POLICY.to_json().encode(), "application/json")
    return office.client.post("/admin/policies", files={"file": file})


def _activate(office: Office) -> Any:
    _upload(office)
    path = f"/admin/policies/{POLICY.sha256}/activate"
    return office.send(path, study="demo", confirmed="yes")


def _time_out(office: Office) -> Any:
    bots = office.send_json("/api/v1/studies/demo/bots", {"count": 1}).json()["bots"]
    return office.send_json("/api/v1/studies/demo/bots/time-out", {"codes": [bots[0]["code"]]})


def _reinstate(path: str, how: str) -> Act:
    def act(office: Office) -> Any:
        send = getattr(office, "send" if how == "data" else "send_json")
        reason = {"reason": "slept"}
        address = path.format(code=office.code)
        for move in ("exclude", "reinstate"):  # who is excluded already stays so
            where = f"{address}/{move}"
            answer = send(where, **reason) if how == "data" else send(where, reason)
        return answer

    return act


_PERSON, _API_PERSON = "/admin/participants/{code}", "/api/v1/participants/{code}"
ACTS: dict[tuple[str, str], tuple[str, Act]] = {
    ("POST", "/login"): (
        "signed in",
        lambda o: o.send("/login", name="the-admin", password=PASSWORD),
    ),
    ("POST", "/logout"): ("signed out", lambda o: o.send("/logout")),
    ("POST", f"{_PERSON}/exclude"): (
        "participant excluded",
        lambda o: o.send(f"/admin/participants/{o.code}/exclude", reason="slept"),
    ),
    ("POST", f"{_PERSON}/reinstate"): ("participant reinstated", _reinstate(_PERSON, "data")),
    ("POST", f"{_PERSON}/note"): (
        "note written",
        lambda o: o.send(f"/admin/participants/{o.code}/note", note="called"),
    ),
    ("POST", "/admin/live/{trial}/note"): (
        "note written",
        lambda o: o.send(f"/admin/live/{o.trial}/note", note="stands", tick="30"),
    ),
    ("POST", "/admin/live/{trial}/extend"): (
        "time extended",
        lambda o: o.send(f"/admin/live/{o.trial}/extend", minutes="30"),
    ),
    ("POST", "/admin/policies"): ("policy uploaded", _upload),
    ("POST", "/admin/policies/{sha256}/activate"): ("policy activated", _activate),
    ("GET", "/admin/export"): (
        "export downloaded",
        lambda o: o.client.get("/admin/export?study=demo"),
    ),
    ("GET", "/api/v1/studies/{study_id}/export"): (
        "export downloaded",
        lambda o: o.client.get("/api/v1/studies/demo/export"),
    ),
    ("POST", f"{_API_PERSON}/exclude"): (
        "participant excluded",
        lambda o: o.send_json(f"/api/v1/participants/{o.code}/exclude", {"reason": "slept"}),
    ),
    ("POST", f"{_API_PERSON}/reinstate"): (
        "participant reinstated",
        _reinstate(_API_PERSON, "json"),
    ),
    ("POST", "/api/v1/studies/{study_id}/bots"): (
        "bots issued",
        lambda o: o.send_json("/api/v1/studies/demo/bots", {"count": 2}),
    ),
    ("POST", "/api/v1/studies/{study_id}/bots/time-out"): ("bots timed out", _time_out),
    ("POST", "/expert/runs"): (
        "learning run started",
        lambda o: o.send("/expert/runs", **fresh_values()),
    ),
    ("POST", "/expert/runs/{run_id}/worker-link"): (
        "worker link made",
        lambda o: o.send(f"{o.start_run()}/worker-link"),
    ),
    ("POST", "/expert/runs/{run_id}/stop"): (
        "learning run stopped",
        lambda o: o.send(f"{o.start_run()}/stop"),
    ),
}


async def _export_little(*options: Any) -> AsyncIterator[bytes]:
    del options

    async def pieces() -> AsyncIterator[bytes]:
        yield b"PK"

    return pieces()


@pytest.fixture
def office(
    client: TestClient, app: FastAPI, walker: Any, sign_in_as: Any, monkeypatch: pytest.MonkeyPatch
) -> Office:
    """Hashing is made quick, an export is a few bytes, and every trial counts as running."""
    hasher = PasswordHash((Argon2Hasher(time_cost=1, memory_cost=64, parallelism=1),))
    monkeypatch.setattr("server.desks.accounts._hasher", lambda: hasher)
    _decoy_hash.cache_clear()
    monkeypatch.setattr(LiveWatch, "require_running", lambda self, trial: None)
    monkeypatch.setattr("server.export.download.begin_export", _export_little)
    walker.walk_to("trial-1")
    trial = walker.end_trial()
    services = app.state.services
    portal = client.portal
    assert portal is not None
    portal.call(add_user, services.database, "the-admin", "admin", PASSWORD)
    code = portal.call(services.participants.look_up, walker.token).participant.code
    sign_in_as("admin")
    portal.call(add_user, services.database, "the-admin", "admin", PASSWORD)
    office = Office(client, app, code, trial)
    office.send("/login", name="the-admin", password=PASSWORD)
    return office


def test_every_door_through_which_staff_do_something_is_listed_here(app: FastAPI) -> None:
    """Whoever adds one says here what it leaves in the audit."""
    doing = {
        (method, path)
        for method, path in addresses(app)
        if method != "GET" and not path.startswith(OF_PARTICIPANTS)
    }
    assert doing | set(DOWNLOADS) == set(ACTS)
    assert {path for _, path in ACTS} & set(OPEN_TO_ALL) == {"/login"}


def test_what_staff_do_leaves_one_row(office: Office, audit: Any) -> None:
    """Of each act by this account; what it was done to stands beside it."""
    for (method, path), (action, act) in ACTS.items():
        door, before = f"{method} {path}", len(audit())
        answer = act(office)
        assert answer.status_code in (200, 201, 303), f"{door}: {answer.text}"
        new = audit()[before:]
        told = [(who, what) for who, what, _ in new if what == action]
        assert (told, new[-1][1]) == ([("the-admin", action)], action), door
        assert _what_it_was_done_to(office, path) in new[-1][2], door
        if path == "/logout":
            office.send("/login", name="the-admin", password=PASSWORD)


def _what_it_was_done_to(office: Office, path: str) -> str:
    if "{code}" in path or "{trial}" in path:
        return office.code
    if "{study_id}" in path or path == "/admin/export":
        return "demo"
    return POLICY.sha256 if "policies" in path else ""


def test_what_was_refused_did_not_happen_and_leaves_no_row(office: Office, audit: Any) -> None:
    """No reason, no note, no such moment, choice, policy or mode, another site's form."""
    before = audit()
    person = f"/admin/participants/{office.code}"
    refused = [
        office.send(f"{person}/exclude", reason=" "),
        office.send(f"{person}/reinstate", reason="was not excluded"),
        office.send(f"{person}/note", note=""),
        office.send(f"/admin/live/{office.trial}/note", note="x", tick="soon"),
        office.send(f"/admin/live/{'0' * 32}/note", note="x", tick="1"),
        office.send(f"/admin/live/{office.trial}/extend", minutes="11"),
        office.send(f"/admin/policies/{'0' * 64}/activate", study="demo", confirmed="yes"),
        office.send(f"/admin/policies/{shipped_policy().sha256}/activate", study="nope"),
        office.client.post("/admin/policies", files={"file": ("p.json", b"{}")}),
        office.client.get("/admin/export?study=demo&mode=all"),
        office.send_json("/api/v1/studies/demo/bots", {"count": 0}),
        office.client.post(
            f"{person}/exclude", data={"reason": "x"}, headers={"origin": "https://evil.example"}
        ),
    ]
    assert [answer.status_code for answer in refused if answer.status_code < 400] == []
    assert audit() == before


def test_a_refused_sign_in_and_an_erasure_leave_their_rows(office: Office, audit: Any) -> None:
    """By the name that was tried, and by the command line."""
    office.client.cookies.clear()
    office.send("/login", name="maria", password="wrong, but long enough")
    assert audit()[-1][:2] == ("maria", "sign-in refused")
    desk = LifeDesk(office.app.state.services.database)
    assert office.client.portal is not None
    office.client.portal.call(desk.erase, office.code, "command line")
    assert audit()[-1] == ("command line", "participant erased", office.code)
