"""A whole live learning run in two real Chromium windows: the worker's and the expert's.

The expert's toggles arrive in the worker's view, iterations advance, the expert stops the run, and
the stored pairs hold what was set in the grid, no more and no less.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from itertools import groupby

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, Page, expect

from browser.conftest import ADMIN_PASSWORD, TAP, Server
from browser.expert_page import facts, sign_in, start_run

ROBOTS, STATIONS = 6, 4
LIVE, GHOST, TRAJECTORY, BALLOON = 1, 2, 4, 1
STORED_ITERATIONS = """least => Number(/iteration (\\d+)/.exec(
    document.querySelector(".chart").getAttribute("aria-label") ?? "")?.[1]) >= least"""
GESTURES = [  # keys, and what they switch: agent and bits
    ("1t", (0, TRAJECTORY)), ("2l", (1, LIVE)), ("s1b", (ROBOTS, BALLOON)), ("3 ", (2, 7)),
    ("1t", (0, TRAJECTORY)), ("4g", (3, GHOST)),
]  # fmt: skip
SHOWN = """([agent, bits, robots]) => {
    const display = tap.displays.at(-1);
    const mask = agent < robots ? display[3 + agent] : display[4 + agent];
    return (mask & bits) === 0;
}"""


@pytest.fixture
def windows(browser: Browser) -> Iterator[tuple[Page, Page]]:
    """Two windows of two people, the worker's and the expert's, who share nothing."""
    sizes = ({"width": 480, "height": 270}, {"width": 1024, "height": 560})
    contexts = [browser.new_context(viewport=size) for size in sizes]  # type: ignore[arg-type]
    for context in contexts:
        context.set_default_timeout(60_000)
        context.add_init_script(TAP)
    yield contexts[0].new_page(), contexts[1].new_page()
    for context in contexts:
        context.close()


def begin(page: Page, server: Server) -> str:
    """Sign in and start a run by its form; returns the worker's link."""
    sign_in(page, server.url, "admin", ADMIN_PASSWORD)
    start_run(page, server.url, worker="person")
    expect(page.locator(".notices > .note")).to_contain_text("Waiting for the worker")
    check_with_axe(page)
    link = page.locator("#worker-link a").get_attribute("href")
    assert link is not None
    return link


def check_with_axe(page: Page) -> None:
    """Nothing on the page bars anybody."""
    found = Axe().run(page).response["violations"]
    assert [(v["id"], [node["target"] for node in v["nodes"]]) for v in found] == []


def apply(masks: list[int], gestures: list[tuple[str, tuple[int, int]]]) -> list[int]:
    """Masks by agent after some gestures, each of which switches bits over."""
    masks = list(masks)
    for _, (agent, bits) in gestures:
        masks[agent] ^= bits
    return masks


def teach(worker: Page, expert: Page) -> None:
    """One gesture after the other; the next comes when pairs were taken since."""
    for number, (keys, (agent, bits)) in enumerate(GESTURES):
        pairs = int(facts(expert)["pairs"])
        expert.keyboard.type(keys)
        if number == 0:  # beta is 1: every agent shows the expert's setting
            worker.wait_for_function(SHOWN, arg=[agent, bits, ROBOTS])
        expert.wait_for_function("pairs => Number(stage.dataset.pairs) > pairs", arg=pairs)
    expert.wait_for_function("() => stage.dataset.pending === '0'")


def test_what_an_expert_sets_is_seen_learned_and_stored(
    learning_server: Server, windows: tuple[Page, Page]
) -> None:
    """Toggles arrive, iterations advance, the view changes, the pairs equal the clicks."""
    worker, expert = windows
    worker.goto(begin(expert, learning_server))
    expert.wait_for_function("() => stage.dataset.phase === 'running'")
    expect(expert.locator("#recording")).to_have_text("Recording")
    teach(worker, expert)
    stored = int(facts(expert)["iteration"]) + 2
    assert stored > 3
    expert.wait_for_function(STORED_ITERATIONS, arg=stored)

    expert.get_by_text("About this run").click()
    expert.get_by_text("Stop this run").click()
    expert.get_by_role("button", name="Stop it for good").click()
    expect(expert.get_by_role("heading", name="This run was stopped")).to_be_visible()
    expect(worker.get_by_role("heading", name="The run has ended")).to_be_visible(timeout=60_000)
    check_with_axe(worker)
    expert.wait_for_function(STORED_ITERATIONS, arg=stored)
    with expert.expect_download() as download:
        expert.get_by_role("link", name="Download the dataset").click()
    rows = list(csv.DictReader(io.StringIO(download.value.path().read_text())))
    assert len(rows) >= 25 * stored
    check_pairs(rows)


def check_pairs(rows: list[dict[str, str]]) -> None:
    """At each snapshot all boxes are those after the same number of gestures, in their order."""
    assert [int(row["iteration"]) for row in rows] == [n // 25 for n in range(len(rows))]
    states = [apply([7] * ROBOTS + [1] * STATIONS, GESTURES[:n]) for n in range(len(GESTURES) + 1)]
    done = 0
    for moment, group in groupby(rows, key=lambda row: (row["trial"], int(row["tick"]))):
        boxes = {
            int(row["agent"]) + (ROBOTS if row["agent_kind"] == "station" else 0): int(row["box"])
            for row in group
        }
        fitting = [
            n
            for n, masks in enumerate(states)
            if n >= done and all(masks[agent] == box for agent, box in boxes.items())
        ]
        assert fitting, f"{moment}: no gestures after the first {done} give {boxes}"
        done = fitting[0]
    assert done == len(GESTURES)
