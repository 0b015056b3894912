"""A scripted run and the expert's page on it, as tests use them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import httpx2
from playwright.sync_api import Locator, Page

from browser.scripted_run import RUN_ID

if TYPE_CHECKING:
    from browser.conftest import Server

PAGE = f"/expert/runs/{RUN_ID}"
READY = """() => { const { frames, boxes, connection } = document.querySelector("#stage").dataset;
    return Number(frames) > 1 && boxes && connection === "open"; }"""
LISTEN = """window.complaints = [];
    addEventListener("securitypolicyviolation", (event) => complaints.push(event.blockedURI));
    addEventListener("error", (event) => complaints.push(event.message));"""
DRAW_NOTHING = """for (const name of ["drawArrays", "drawElements", "drawElementsInstanced",
    "drawArraysInstanced", "clear"]) WebGL2RenderingContext.prototype[name] = () => {};"""
ALL_ON = [7] * 12 + [1] * 4
CALM = {
    "hold": False, "refuse": "", "away": False, "phase": "running", "lead": "first",
    "others": [], "agreement": [], "status": "open", "boxes": ALL_ON,
}  # fmt: skip


def sign_in(page: Page, url: str, name: str, password: str) -> None:
    """Sign in by the form."""
    page.goto(f"{url}/login")
    page.get_by_label("Name").fill(name)
    page.get_by_label("Password").fill(password)
    page.get_by_role("button", name="Sign in").click()


def start_run(page: Page, url: str, **values: str) -> None:
    """Start a run in the hall `small` with independent boxes by the form, and wait for its world.

    `values`: more of the form's fields by name.
    """
    page.goto(f"{url}/expert")
    if not page.get_by_role("button", name="Start the run").is_visible():
        page.get_by_text("Start a new run").click()
    for name, value in {"scale": "small", "box_mode": "independent", **values}.items():
        field = page.locator(f"[name={name}]")
        is_choice = field.evaluate("field => field.matches('select')")
        field.select_option(value) if is_choice else field.fill(value)
    page.get_by_role("button", name="Start the run").click()
    page.wait_for_function("() => Number(document.querySelector('#stage')?.dataset.frames) > 0")


def facts(page: Page) -> dict[str, Any]:
    """What the expert's page thinks of itself."""
    data: dict[str, Any] = page.evaluate("() => ({...document.querySelector('#stage').dataset})")
    return data


def open_calm_run(page: Page, fake: Server) -> None:
    """Bring the page to the calm run, with every box on, nothing waiting, the first row chosen."""
    turn(fake, **CALM)
    if PAGE not in page.url or page.locator(".banner[data-kind=ended]").is_visible():
        page.goto(fake.url + PAGE)
    page.wait_for_function(READY)
    wait_for_boxes(page, ALL_ON)
    wait_until_stored(page)
    page.keyboard.press("1")
    page.keyboard.press("Escape")


def turn(fake: Server, **knobs: Any) -> None:
    """Turn knobs of the scripted run."""
    httpx2.post(f"{fake.url}/knobs", json=knobs).raise_for_status()


def heard(fake: Server, kind: str) -> list[dict[str, Any]]:
    """What pages sent of one kind, in order."""
    record = httpx2.get(f"{fake.url}/heard").json()
    return [message for message in record["heard"] if message["type"] == kind]


def boxes(fake: Server) -> list[int]:
    """The boxes as the server has them."""
    record: dict[str, list[int]] = httpx2.get(f"{fake.url}/heard").json()
    return record["boxes"]


def wait_for_boxes(page: Page, expected: list[int]) -> None:
    """Wait until the page shows these boxes."""
    page.wait_for_function("text => stage.dataset.boxes === text", arg=",".join(map(str, expected)))


def wait_until_stored(page: Page) -> None:
    """Wait until no change of this page waits."""
    page.wait_for_function("() => stage.dataset.pending === '0'")


def cell(page: Page, agent: int, element: str) -> Locator:
    """A cell of the grid."""
    return page.locator(f".cell[data-agent='{agent}'][data-element='{element}']")
