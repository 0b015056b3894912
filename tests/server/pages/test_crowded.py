"""Guards staff's pages when many take part: how much they read is bounded, and axe finds nothing.

Pages are read off the app, so that a new one cannot be forgotten.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime

import pytest
from fastapi import FastAPI
from playwright.sync_api import Page
from sqlalchemy import Engine, event
from starlette.testclient import TestClient

from study.config import Study
from tests.server.crowd import add_crowd
from tests.server.pages.looking import problems_of
from tests.server.test_roles import addresses

PEOPLE = 140  # more than a page of any list holds
STATEMENTS, SIZE_KB = 20, 60
DOWNLOADS = ("/admin/export", "/admin/policies/{sha256}/file.json")
SOMEBODY = {"{code}": "P-B0000001", "{trial}": f"{1:026d}trial1", "{step}": "questionnaire-1"}
SignIn = Callable[[str], TestClient]


@pytest.fixture
def crowd(app: FastAPI, client: TestClient, study: Study) -> Callable[[int], None]:
    """Lets so many take part."""

    def fill(people: int) -> None:
        assert client.portal is not None
        now = datetime.now(UTC)
        client.portal.call(add_crowd, app.state.services.database, study, people, now)

    return fill


def pages_of(app: FastAPI, client: TestClient) -> list[str]:
    """Addresses of every page of administrators, about somebody where they are about one."""
    policy = client.get("/admin/policies").text.split('href="/admin/policies/')[1][:64]
    places = SOMEBODY | {"{sha256}": policy}
    found = []
    for method, path in addresses(app):
        if method == "GET" and path.startswith("/admin") and path not in DOWNLOADS:
            for name, value in places.items():
                path = path.replace(name, value)
            found.append(path)
    assert not [path for path in found if "{" in path]
    return sorted(set(found))


@contextmanager
def counting() -> Iterator[list[int]]:
    """Counts the statements sent to any database."""
    counts = [0]

    def count(*args: object) -> None:
        del args
        counts[0] += 1

    event.listen(Engine, "before_cursor_execute", count)
    try:
        yield counts
    finally:
        event.remove(Engine, "before_cursor_execute", count)


def test_pages_do_not_grow_with_the_study(
    app: FastAPI, sign_in_as: SignIn, crowd: Callable[[int], None]
) -> None:
    """However many take part, a page asks a few questions and lists no more than fits it."""
    admin = sign_in_as("admin")
    crowd(PEOPLE)
    costly = {}
    for path in pages_of(app, admin):
        with counting() as counts:
            page = admin.get(path, follow_redirects=True)
        assert page.status_code == 200, f"{path}: {page.status_code}"
        cost = counts[0], len(page.content) // 1000
        if cost[0] > STATEMENTS or cost[1] > SIZE_KB:
            costly[path] = cost
    assert costly == {}
    assert counts[0] > 1, "nothing was counted"
    rows = [line for line in admin.get("/admin/participants").text.split("<tr>") if "P-B0" in line]
    assert len(rows) == 50
    assert 'data-state="problem"' not in admin.get("/admin/data").text


@pytest.mark.browser
@pytest.mark.parametrize("people", [0, 12])
def test_axe_finds_nothing_on_any_page(
    chromium_page: Page,
    app: FastAPI,
    sign_in_as: SignIn,
    crowd: Callable[[int], None],
    people: int,
) -> None:
    """With nobody, and with some in every state, wide and narrow."""
    admin = sign_in_as("admin")
    crowd(people)
    paths = [p for p in pages_of(app, admin) if people or SOMEBODY["{code}"] not in p]
    paths = [p for p in paths if people or SOMEBODY["{trial}"] not in p]
    found = {}
    for path in paths:
        chromium_page.goto(f"http://testserver{path}")
        found[path] = problems_of(chromium_page)
    assert {path: what for path, what in found.items() if what} == {}
    assert len(found) > 9
