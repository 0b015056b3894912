"""Guards the staff's doors: who may open what, and that guessing is slow."""

from __future__ import annotations

import io
import zipfile
from typing import Any

import pytest
from fastapi import FastAPI
from pwdlib import PasswordHash
from pwdlib.hashers.argon2 import Argon2Hasher
from starlette.testclient import TestClient

from server.desks.accounts import AccountError, _decoy_hash, add_user, ensure_admin
from server.settings import Settings
from server.signin import COOKIE
from server.store.audit import AuditWanted, search_audit
from server.store.users import find_user

PASSWORD = "a long enough password"
HOMES = {"admin": "/admin", "expert": "/expert"}


@pytest.fixture(autouse=True)
def _quick_hashing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Real hashing takes a quarter of a second each time; one test below uses it."""
    hasher = PasswordHash((Argon2Hasher(time_cost=1, memory_cost=64, parallelism=1),))
    monkeypatch.setattr("server.desks.accounts._hasher", lambda: hasher)
    _decoy_hash.cache_clear()


def call(client: TestClient, function: Any, *args: Any) -> Any:
    assert client.portal is not None
    return client.portal.call(function, *args)


@pytest.fixture
def staffed(client: TestClient, app: FastAPI) -> TestClient:
    database = app.state.services.database
    for role in ("admin", "expert"):
        call(client, add_user, database, f"the-{role}", role, PASSWORD)
    return client


def sign_in(client: TestClient, role: str, password: str = PASSWORD) -> Any:
    return client.post("/login", data={"name": f"the-{role}", "password": password})


def actions(client: TestClient, app: FastAPI) -> list[tuple[str, str]]:
    async def read() -> list[tuple[str, str]]:
        async with app.state.services.database.reading() as session:
            found, _ = await search_audit(session, AuditWanted(), offset=0, limit=50)
            return [(name, action) for _, name, action, _ in found]

    return list(call(client, read))


@pytest.mark.parametrize("role", ["admin", "expert"])
def test_each_role_is_led_to_its_own_page(staffed: TestClient, role: str) -> None:
    answer = sign_in(staffed, role)
    assert (answer.status_code, answer.headers["location"]) == (303, HOMES[role])
    cookie = answer.headers["set-cookie"].lower()
    assert "httponly" in cookie
    assert "samesite=lax" in cookie
    assert staffed.get(HOMES[role]).status_code == 200
    assert staffed.get("/login").headers["location"] == HOMES[role]


@pytest.mark.parametrize("address", ["/admin", "/admin/export"])
def test_an_expert_cannot_open_participants_data(staffed: TestClient, address: str) -> None:
    sign_in(staffed, "expert")
    answer = staffed.get(address)
    assert answer.status_code == 403
    assert "admin" in answer.text


@pytest.mark.parametrize("address", ["/admin", "/admin/export", "/expert"])
def test_nobody_gets_in_unsigned(client: TestClient, address: str) -> None:
    assert client.get(address).headers["location"] == "/login"
    client.cookies.set(COOKIE, "forged.cookie.value")
    assert client.get(address).headers["location"] == "/login"


def test_a_wrong_password_and_an_unknown_name_look_the_same(staffed: TestClient) -> None:
    wrong = staffed.post("/login", data={"name": "the-admin", "password": "x"})
    unknown = staffed.post("/login", data={"name": "the-nobody", "password": "x"})
    assert wrong.status_code == unknown.status_code == 401
    assert wrong.text.replace("the-admin", "N") == unknown.text.replace("the-nobody", "N")
    assert "set-cookie" not in wrong.headers


def test_guessing_is_slowed_down_even_for_the_right_password(staffed: TestClient) -> None:
    for _ in range(5):
        assert sign_in(staffed, "admin", "wrong").status_code == 401
    refused = sign_in(staffed, "admin")
    assert refused.status_code == 429
    assert refused.headers["retry-after"] == "60"
    assert sign_in(staffed, "expert").status_code == 303


def test_signing_out_and_a_new_password_end_a_sign_in(staffed: TestClient, app: FastAPI) -> None:
    sign_in(staffed, "admin")
    cookie = staffed.cookies[COOKIE]
    assert staffed.post("/logout").headers["location"] == "/login"
    assert COOKIE not in staffed.cookies
    staffed.cookies.set(COOKIE, cookie)
    assert staffed.get("/admin").status_code == 200
    database = app.state.services.database
    call(staffed, add_user, database, "the-admin", "admin", "another password")
    assert staffed.get("/admin").headers["location"] == "/login"


def test_a_changed_role_counts_at_once(staffed: TestClient, app: FastAPI) -> None:
    sign_in(staffed, "admin")
    call(staffed, add_user, app.state.services.database, "the-admin", "expert", PASSWORD)
    assert staffed.get("/admin").status_code != 200


def test_staff_actions_are_written_down(staffed: TestClient, app: FastAPI) -> None:
    sign_in(staffed, "admin", "wrong")
    sign_in(staffed, "admin")
    staffed.get("/admin/export")
    staffed.post("/logout")
    assert [action for name, action in actions(staffed, app) if name == "the-admin"] == [
        "signed out",
        "export downloaded",
        "signed in",
        "sign-in refused",
    ]


def test_the_list_shows_who_takes_part_and_the_export_can_be_downloaded(
    staffed: TestClient, walker: Any
) -> None:
    walker.walk_to("trial-2")
    sign_in(staffed, "admin")
    page = staffed.get("/admin/participants").text
    assert "trial-2" in page
    assert "active" in page
    assert walker.token not in page
    answer = staffed.get("/admin/export", params={"study": "demo", "mode": "pilot"})
    assert answer.headers["content-type"] == "application/zip"
    with zipfile.ZipFile(io.BytesIO(answer.content)) as bundle:
        assert bundle.testzip() is None
        assert bundle.read("trials.csv").count(b"\n") == 2


def test_a_list_longer_than_a_page_is_paged(staffed: TestClient, join: Any) -> None:
    for _ in range(51):
        join()
    sign_in(staffed, "admin")
    first, second = (
        staffed.get("/admin/participants").text,
        staffed.get("/admin/participants?page=2").text,
    )
    assert (first.count('scope="row"'), second.count('scope="row"')) == (50, 1)
    assert "Page 2 of 2" in second
    assert staffed.get("/admin/participants?page=99").status_code == 200


@pytest.mark.parametrize(
    ("query", "status"), [("study=nope", 404), ("mode=all", 400), ("study=demo&mode=live", 200)]
)
def test_an_export_of_something_unknown_is_refused(
    staffed: TestClient, query: str, status: int
) -> None:
    sign_in(staffed, "admin")
    assert staffed.get(f"/admin/export?{query}").status_code == status


def test_the_first_administrator_is_made_once(client: TestClient, app: FastAPI) -> None:
    database, settings = app.state.services.database, app.state.services.settings
    password = call(client, ensure_admin, database, settings)
    assert len(password) >= 20
    assert call(client, ensure_admin, database, settings) is None
    assert client.post("/login", data={"name": "admin", "password": password}).status_code == 303


def test_a_configured_password_is_used_and_never_given_out(
    client: TestClient, app: FastAPI
) -> None:
    settings = Settings(admin_password=PASSWORD)  # type: ignore[arg-type]
    assert call(client, ensure_admin, app.state.services.database, settings) is None
    assert client.post("/login", data={"name": "admin", "password": PASSWORD}).status_code == 303
    assert PASSWORD not in repr(settings)


@pytest.mark.parametrize(
    ("name", "role", "password", "told"),
    [
        ("", "admin", PASSWORD, "name"),
        ("a b", "admin", PASSWORD, "name"),
        ("a", "root", PASSWORD, "admin or expert"),
        ("a", "admin", "short", "at least 10"),
    ],
)
def test_an_unusable_account_is_refused(
    client: TestClient, app: FastAPI, name: str, role: str, password: str, told: str
) -> None:
    with pytest.raises(AccountError, match=told):
        call(client, add_user, app.state.services.database, name, role, password)


def test_passwords_are_stored_as_argon2id(
    client: TestClient, app: FastAPI, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("server.desks.accounts._hasher", PasswordHash.recommended)
    database = app.state.services.database
    call(client, add_user, database, "real", "expert", PASSWORD)

    async def read() -> str:
        async with database.reading() as session:
            user = await find_user(session, "real")
        assert user is not None
        return user.password_hash

    assert call(client, read).startswith("$argon2id$v=19$m=65536")
    assert client.post("/login", data={"name": "real", "password": PASSWORD}).status_code == 303
