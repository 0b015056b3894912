"""Guards every page with forms: axe finds nothing, and nothing sticks out of a narrow window."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from fastapi import FastAPI
from playwright.sync_api import Page
from starlette.testclient import TestClient

from server.desks.accounts import add_user
from tests.server.bad_policies import make_policy
from tests.server.pages.looking import problems_of

PASSWORD = "a long enough password"
pytestmark = pytest.mark.browser
STEPS = ("consent", "browser-check", "demographics", "instructions", "explanation-1",
         "questionnaire-1", "comments", "debrief")  # fmt: skip
REFUSED = ("consent", "demographics", "questionnaire-1")


@pytest.mark.parametrize("role", ["admin", "expert"])
def test_staff_pages_are_accessible(
    chromium_page: Page, client: TestClient, app: FastAPI, walker: Any, role: str
) -> None:
    """Each role's own page, with a participant on it, and the sign-in that was refused."""
    assert walker.step() == "consent"
    assert client.portal is not None
    client.portal.call(add_user, app.state.services.database, "the-person", role, PASSWORD)
    chromium_page.goto("http://testserver/login")
    chromium_page.fill("input[name=name]", "the-person")
    chromium_page.fill("input[name=password]", "wrong")
    chromium_page.click("main button[type=submit]")
    chromium_page.wait_for_selector("[role=alert]")
    assert problems_of(chromium_page) == []
    signed_in = client.post("/login", data={"name": "the-person", "password": PASSWORD})
    assert signed_in.headers["location"] == f"/{role}"
    chromium_page.goto(f"http://testserver/{role}")
    chromium_page.wait_for_selector("form[action='/logout']")
    assert problems_of(chromium_page) == []


def test_pages_about_runs_and_policies_are_accessible(
    chromium_page: Page, client: TestClient, sign_in_as: Callable[[str], TestClient]
) -> None:
    """Empty, refused, filled, compared; and what a worker sees after the end."""
    sign_in_as("admin")
    site, found = "http://testserver", {}

    def look(name: str, address: str = "") -> None:
        if address:
            chromium_page.goto(f"{site}{address}")
        found[name] = problems_of(chromium_page)

    look("no runs", "/expert")
    chromium_page.fill("#iterations", "0")
    chromium_page.click("main button[type=submit]")
    chromium_page.wait_for_selector("#summary:focus")
    look("run refused")
    chromium_page.fill("#iterations", "3")
    chromium_page.click("main button[type=submit]")
    chromium_page.wait_for_selector("body.run")
    run = client.get("/expert").text.split('href="/expert/runs/')[1][:32]
    look("runs", "/expert")
    look("no policies of a run", f"/admin/policies?run={run}")
    look("policies", "/admin/policies")
    bad = {"name": "x.json", "mimeType": "application/json", "buffer": b"7"}
    chromium_page.set_input_files("#file", bad)  # type: ignore[arg-type]
    chromium_page.click("main button[type=submit]")
    chromium_page.wait_for_selector("#summary:focus")
    look("upload refused")
    one, other = (make_policy(name, "simulated", n) for n, name in enumerate(("one", "other")))
    for policy in (one, other):
        files = {"file": ("p.json", policy.to_json().encode(), "application/json")}
        client.post("/admin/policies", files=files)
    look("compared", f"/admin/policies/{one.sha256}?compare={other.sha256}")
    look("filled", "/admin/policies")
    made = client.post(f"/expert/runs/{run}/worker-link", follow_redirects=True).text
    client.post(f"/expert/runs/{run}/stop")
    look("ended", "/w/" + made.split("/w/")[1][:32])
    assert {name: what for name, what in found.items() if what} == {}


def test_every_form_page_is_accessible(chromium_page: Page, walker: Any) -> None:
    found: dict[str, list[str]] = {}
    for step in STEPS:
        walker.walk_to(step)
        chromium_page.goto(f"http://testserver{walker.address}")
        found[step] = problems_of(chromium_page)
        if step in REFUSED:
            chromium_page.click("button[type=submit]")
            chromium_page.wait_for_selector("#summary:focus")
            found[f"{step} refused"] = problems_of(chromium_page)
    for address in ("/", "/s/demo", "/login", f"{walker.address}/withdraw", "/nothing"):
        chromium_page.goto(f"http://testserver{address}")
        found[address] = problems_of(chromium_page)
    assert {name: what for name, what in found.items() if what} == {}
    assert len(found) == len(STEPS) + len(REFUSED) + 5
