"""What the expert's page shows, in real Chromium against a scripted run.

Who leads, counters, everything in sight, states for everybody's eyes, the end of a run.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page, expect

from browser.conftest import Server
from browser.expert_page import ALL_ON, PAGE, READY, heard, turn, wait_for_boxes

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
