"""The expert's page in real Chromium against a scripted run: keys, pending, lost lines, looks.

The script's knobs bring about what a healthy server seldom does: late storing, refusals, absence.
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterator
from typing import Any

import httpx2
import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, BrowserContext, Locator, Page, expect

from browser.conftest import Server
from browser.scripted_run import RUN_ID

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
OTHERS = [{"name": "ben", "client": "00ff00ff00ff00ff"}]
AGREEMENT = [
    {
        "name": "ben",
        "elements": {
            "trajectory": {"kappa": 0.774, "pairs": 120},
            "live_location": {"kappa": -0.1, "pairs": 212},
            "transparent_avatar": {"kappa": 0.5, "pairs": 120},
            "balloon": {"kappa": None, "pairs": 3},
        },
    }
]


@pytest.fixture(scope="module")
def fake(start_server: Callable[..., Server]) -> Server:
    """A scripted run in the hall of the study: 12 robots, 4 stations."""
    return start_server("study", script="serve_fake_run.py")


@pytest.fixture(scope="module")
def context(browser: Browser) -> Iterator[BrowserContext]:
    """A window of 1280 x 720."""
    fresh = browser.new_context(viewport={"width": 1280, "height": 720})
    fresh.set_default_timeout(60_000)
    fresh.add_init_script(LISTEN + DRAW_NOTHING)
    yield fresh
    fresh.close()


@pytest.fixture(scope="module")
def shared_page(context: BrowserContext) -> Page:
    """One page for all tests that do not end it; complaints of the browser are kept."""
    return context.new_page()


@pytest.fixture
def desk(shared_page: Page, fake: Server) -> Page:
    """The page of the calm run, with every box on and nothing waiting."""
    turn(fake, **CALM)
    if PAGE not in shared_page.url or shared_page.locator(".banner[data-kind=ended]").is_visible():
        shared_page.goto(fake.url + PAGE)
    shared_page.wait_for_function(READY)
    wait_for_boxes(shared_page, ALL_ON)
    shared_page.wait_for_function("() => stage.dataset.pending === '0'")
    shared_page.keyboard.press("1")
    shared_page.keyboard.press("Escape")
    return shared_page


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
    page.wait_for_function("() => stage.dataset.pending === '0'")


def cell(page: Page, agent: int, element: str) -> Locator:
    """A cell of the grid."""
    return page.locator(f".cell[data-agent='{agent}'][data-element='{element}']")


def test_more_than_two_edits_a_second_by_keys(desk: Page, fake: Server) -> None:
    """Each robot gets two edits of its own and the last ones are confirmed as stored."""
    before = len(heard(fake, "edit"))
    began_s = time.perf_counter()
    for robot in range(1, 13):
        desk.keyboard.type(f"{robot}{'tl'[robot % 2]}g")
    wait_until_stored(desk)
    took_s = time.perf_counter() - began_s
    edits = heard(fake, "edit")[before:]
    assert len(edits) == 24
    assert took_s < 10, f"24 edits took {took_s:.1f} s"
    assert boxes(fake) == [7 - 2 - (1 if robot % 2 else 4) for robot in range(1, 13)] + [1] * 4
    assert [edit["seq"] for edit in edits] == list(range(edits[0]["seq"], edits[0]["seq"] + 24))
    assert all(edit["trial"] == 2 and edit["tick"] > 900 for edit in edits)


def test_rows_columns_stations_undo_and_right_by_keys(desk: Page, fake: Server) -> None:
    """Every kind of gesture reaches the server as one message, and undo is its inverse."""
    before = len(heard(fake, "edit"))
    for keys, expected in (
        (["3", "Space"], [[2, 0, 7]]),
        (["ArrowDown", "t"], [[3, 0, 4]]),
        (["Shift+g"], [[n, 2, 0] for n in (2,)]),
        (["s", "2", "b"], [[13, 0, 1]]),
        (["Shift+B"], [[13, 1, 0]]),
        (["u"], [[13, 0, 1]]),
        (["Control+z"], [[13, 1, 0]]),
        (["1", "2", "ArrowRight", "Enter"], [[11, 0, 1]]),
    ):
        for key in keys:
            desk.keyboard.press(key)
        wait_until_stored(desk)
        assert heard(fake, "edit")[before:][-1]["changes"] == expected, keys
    desk.keyboard.press("r")
    desk.keyboard.press("Shift+R")
    wait_until_stored(desk)
    one, every = heard(fake, "confirm")[-2:]
    assert (one["agents"], every["agents"]) == ([11], list(range(16)))
    expect(desk.locator("tr[data-agent='11']")).to_have_attribute("data-confirmed", "done")


def test_keys_leave_text_fields_and_focused_buttons_alone(desk: Page, fake: Server) -> None:
    """Typing into a field sets nothing; a button reached by Tab takes Space for itself."""
    before = len(heard(fake, "edit"))
    desk.evaluate("() => document.body.append(document.createElement('textarea'))")
    desk.locator("textarea").press_sequentially("3tlg r")
    desk.evaluate("() => document.querySelector('textarea').remove()")
    hamming = desk.get_by_role("button", name="Hamming")
    hamming.focus()
    desk.keyboard.press("Space")
    expect(hamming).to_have_attribute("aria-pressed", "true")
    desk.get_by_role("button", name="Shown", exact=True).click()
    assert len(heard(fake, "edit")) == before
    desk.keyboard.press("Space")
    wait_for_boxes(desk, [0, *ALL_ON[1:]])


def test_the_mouse_and_the_tab_key_reach_cells_and_columns(desk: Page, fake: Server) -> None:
    """A click switches one cell; Tab stops once in the grid, where arrows and Enter go on."""
    cell(desk, 4, "trajectory").click()
    wait_for_boxes(desk, [*ALL_ON[:4], 3, *ALL_ON[5:]])
    expect(cell(desk, 4, "trajectory")).to_have_attribute("aria-checked", "false")
    desk.get_by_title("Switch the whole column (Shift+B)").click()
    wait_for_boxes(desk, [*ALL_ON[:4], 3, *ALL_ON[5:12], 0, 0, 0, 0])
    assert desk.locator(".agents [tabindex='0']").count() == 1
    desk.locator(".agents [tabindex='0']").focus()
    desk.keyboard.press("ArrowDown")
    desk.keyboard.press("Enter")
    wait_for_boxes(desk, [*ALL_ON[:4], 3, 3, *ALL_ON[6:12], 0, 0, 0, 0])
    wait_until_stored(desk)
    assert boxes(fake)[4:6] == [3, 3]


def test_a_lost_line_loses_nothing_and_says_how_much_waits(desk: Page, fake: Server) -> None:
    """Unstored changes are sent again with their numbers, and are applied once."""
    turn(fake, hold=True)
    desk.keyboard.type("2t5l")
    expect(cell(desk, 1, "trajectory")).to_have_attribute("data-pending", "")
    turn(fake, away=True, drop=True)
    banner = desk.get_by_role("alert")
    expect(banner).to_contain_text("Connection lost")
    expect(banner).to_contain_text("2 still waiting")
    sent = heard(fake, "edit")[-2:]
    desk.keyboard.type("7t")
    expect(desk.locator(".toast")).to_contain_text("nothing can be set until it is back")
    turn(fake, away=False)
    expect(banner).to_be_hidden()
    desk.wait_for_function("() => stage.dataset.connection === 'open'")
    expect(cell(desk, 1, "trajectory")).to_have_attribute("data-pending", "")
    turn(fake, hold=False)
    wait_until_stored(desk)
    again = heard(fake, "edit")[-2:]
    assert [edit["seq"] for edit in again] == [edit["seq"] for edit in sent]
    assert boxes(fake) == [7, 3, 7, 7, 6, *ALL_ON[5:]]
    expect(cell(desk, 1, "trajectory")).not_to_have_attribute("data-pending", "")


def test_a_refused_change_is_taken_back_with_the_servers_sentence(desk: Page, fake: Server) -> None:
    turn(fake, refuse="Trial 2 is over.")
    desk.keyboard.type("6t")
    expect(desk.locator(".toast")).to_contain_text("Refused: Trial 2 is over.")
    expect(cell(desk, 5, "trajectory")).to_have_attribute("data-refused", "")
    wait_for_boxes(desk, ALL_ON)
    expect(cell(desk, 5, "trajectory")).not_to_have_attribute("data-refused", "")


def test_cameras_follow_keys_wheel_and_clicks(desk: Page) -> None:
    """V goes through the cameras; a click on a robot from above chooses its row."""
    for mode in ("free", "worker", "above"):
        desk.keyboard.press("v")
        expect(desk.locator("#stage")).to_have_attribute("data-camera", mode)
    row = desk.locator("tr.chosen")
    expect(row).to_have_attribute("data-agent", "0")
    station = desk.locator("#stage > .view").bounding_box()
    assert station is not None
    desk.mouse.click(station["x"] + 200, station["y"] + station["height"] - 14)
    expect(row).not_to_have_attribute("data-agent", "0")


def test_lead_hand_over_and_agreement(desk: Page, fake: Server) -> None:
    """Who leads is told and can be changed; kappa stands by element, undefined as a dash."""
    turn(fake, others=OTHERS, agreement=AGREEMENT)
    people = desk.locator("#people")
    expect(people.locator("tbody tr")).to_have_text("ben0.77 n 120-0.10 n 2120.50 n 120– n 3")
    people.get_by_role("button", name="Hand the lead over to ben").click()
    expect(people).to_contain_text("Your settings are kept apart")
    assert heard(fake, "hand_over")[-1]["to"] == OTHERS[0]["client"]
    turn(fake, lead="")
    expect(desk.locator("#recording")).to_have_text("Not recording: nobody has the lead")
    people.get_by_role("button", name="Take the lead").click()
    expect(people.locator("li", has_text="anna (you)")).to_contain_text("lead")
    expect(desk.locator("#recording")).to_have_text("Recording")


def test_counters_ring_and_curves_follow_the_run(desk: Page, fake: Server) -> None:
    turn(fake, iteration=120)
    expect(desk.locator(".counter[data-name=iteration]")).to_contain_text("120 of 240")
    expect(desk.locator(".counter[data-name=beta]")).to_contain_text("0.500")
    expect(desk.locator(".chart")).to_have_attribute(
        "aria-label", re.compile(", iteration 120: Policy ")
    )
    first = desk.locator(".ring-seconds").text_content()
    desk.wait_for_function(
        "text => document.querySelector('.ring-seconds').textContent !== text", arg=first
    )
    turn(fake, phase="paused")
    expect(desk.locator(".ring-caption")).to_have_text("the worker is away")
    expect(desk.locator(".notices > .note")).to_contain_text("paused until the worker is back")


def fits(page: Page) -> bool:
    """Whether rows, ring, counters, chart and experts are seen without scrolling anything."""
    inside: bool = page.evaluate(
        """() => {
        const parts = document.querySelectorAll(
            ".grid tr, .ring, .counter, .chart canvas, .experts, .bar button, #stage > .view");
        const agents = document.querySelector("#agents");
        return document.documentElement.scrollWidth <= innerWidth
            && document.documentElement.scrollHeight <= innerHeight
            && agents.scrollHeight <= agents.clientHeight
            && [...parts].every((part) => {
                const { left, top, right, bottom } = part.getBoundingClientRect();
                return left >= 0 && top >= 0 && right <= innerWidth && bottom <= innerHeight;
            });
    }"""
    )
    return inside


def test_everything_important_is_seen_without_scrolling(
    desk: Page, start_server: Callable[..., Server]
) -> None:
    """12 robots and 4 stations at 1280 x 720 and 1024 x 768, 15 robots at 1920 x 1080."""
    for width, height in ((1280, 720), (1024, 768)):
        desk.set_viewport_size({"width": width, "height": height})
        desk.wait_for_timeout(150)
        assert fits(desk), (width, height)
    desk.set_viewport_size({"width": 1280, "height": 720})
    large = start_server("large", script="serve_fake_run.py")
    page = desk.context.new_page()
    page.set_viewport_size({"width": 1920, "height": 1080})
    page.goto(large.url + PAGE)
    page.wait_for_function(READY)
    assert page.locator(".grid tbody tr").count() == 19
    assert fits(page)
    page.close()


def test_axe_finds_nothing_in_any_state(desk: Page, fake: Server) -> None:
    """The running page, its help, a lost line, and the page of a run that is over."""
    turn(fake, others=OTHERS, agreement=AGREEMENT)
    check_with_axe(desk)
    desk.keyboard.press("?")
    expect(desk.get_by_role("dialog")).to_be_visible()
    check_with_axe(desk)
    desk.keyboard.press("t")
    desk.keyboard.press("Escape")
    expect(desk.get_by_role("dialog")).to_be_hidden()
    wait_for_boxes(desk, ALL_ON)
    turn(fake, away=True, drop=True)
    expect(desk.get_by_role("alert")).to_be_visible()
    check_with_axe(desk)
    assert desk.evaluate("() => complaints") == []


def check_with_axe(page: Page) -> None:
    found = Axe().run(page).response["violations"]
    assert [(v["id"], [node["target"] for node in v["nodes"]]) for v in found] == []


def test_an_ended_run_says_so_and_leads_to_its_data(desk: Page, fake: Server) -> None:
    """On the running page at once; opened later, the page shows curves and agreement."""
    turn(fake, status="finished", agreement=AGREEMENT)
    banner = desk.get_by_role("alert")
    expect(banner).to_contain_text("The run is finished")
    link = banner.get_by_role("link", name="Dataset (CSV)")
    expect(link).to_have_attribute("href", f"{PAGE}/dataset.csv")
    desk.keyboard.type("4t")
    expect(desk.locator(".toast")).to_contain_text("The run has ended.")
    desk.goto(fake.url + PAGE)
    expect(desk.get_by_role("heading", name="This run is finished")).to_be_visible()
    expect(desk.locator("#curves canvas")).to_be_visible()
    expect(desk.locator("#people tbody")).to_contain_text("ben")
    check_with_axe(desk)
