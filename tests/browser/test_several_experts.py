"""Two experts in two real Chromium windows on one live run with a simulated worker.

One leads, the other's settings are kept apart and compared; the lead goes from hand to hand.
"""

from __future__ import annotations

import csv
import io
import sqlite3
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, expect
from sklearn.metrics import cohen_kappa_score

from browser.conftest import ADMIN_PASSWORD, Server
from browser.expert_page import (
    DRAW_NOTHING,
    LISTEN,
    READY,
    facts,
    sign_in,
    start_run,
    wait_for_boxes,
)

ALL_ON = [7] * 6 + [1] * 4
BITS = {"trajectory": 4, "live_location": 1, "transparent_avatar": 2}


@pytest.fixture
def experts(browser: Browser, learning_server: Server) -> Iterator[tuple[Page, Page]]:
    """The windows of the experts admin and ben; admin has started a run, ben has come to it."""
    words = ("user", "add", "ben", "--role", "expert", "--password-stdin")
    learning_server.varil(*words, stdin=f"{ADMIN_PASSWORD}\n")
    contexts = [browser.new_context(viewport={"width": 1024, "height": 720}) for _ in range(2)]
    for context in contexts:
        context.set_default_timeout(60_000)
        context.add_init_script(LISTEN + DRAW_NOTHING)
    first, second = (context.new_page() for context in contexts)
    sign_in(first, learning_server.url, "admin", ADMIN_PASSWORD)
    sign_in(second, learning_server.url, "ben", ADMIN_PASSWORD)
    always = "exponential(1)"  # what is displayed is what the lead has set
    start_run(first, learning_server.url, worker="simulated", beta=always)
    second.goto(first.url)
    second.wait_for_function(READY)
    yield first, second
    for context in contexts:
        context.close()


def test_one_leads_and_the_others_settings_are_kept_apart_and_compared(
    learning_server: Server, experts: tuple[Page, Page]
) -> None:
    """What shows and is learned is the lead's; kappa on the page is that of the stored ratings."""
    admin, ben = experts
    check_ben_is_apart(admin, ben)
    hand_over(admin, ben)
    ben.close()
    expect(admin.locator("#recording")).to_have_text("Not recording: nobody has the lead")
    pairs = facts(admin)["pairs"]
    admin.keyboard.type("4t")  # no longer the lead: kept apart
    wait_until_ticks_passed(admin, 240)
    assert facts(admin)["pairs"] == pairs
    admin.get_by_role("button", name="Take the lead").click()
    admin.wait_for_function("pairs => Number(stage.dataset.pairs) > pairs", arg=int(pairs))
    run_id = admin.url.rsplit("/", 1)[1]
    check_pairs(stop_and_download(admin))
    check_agreement(admin, learning_server, run_id)
    assert admin.evaluate("() => complaints") == []


def check_ben_is_apart(admin: Page, ben: Page) -> None:
    """Who came second sets boxes that nobody sees, and reads so."""
    expect(ben.locator("#people")).to_contain_text("Your settings are kept apart")
    expect(ben.locator(".counter[data-name=own]")).to_contain_text("show the lead's")
    ben.keyboard.type("1t3 ")
    admin.keyboard.type("2l")
    wait_for_boxes(ben, [3, 7, 0, *ALL_ON[3:]])
    wait_for_boxes(admin, [7, 6, *ALL_ON[2:]])
    for page in (admin, ben):
        page.wait_for_function("() => stage.dataset.pending === '0'")
        page.wait_for_function("text => stage.dataset.shown === text", arg=join(7, 6))
        expect(page.locator("#people tbody tr")).to_contain_text("ben")


def hand_over(admin: Page, ben: Page) -> None:
    """The lead goes to ben with the boxes as they stand; his former ones end with that."""
    admin.get_by_role("button", name="Hand the lead over to ben").click()
    expect(ben.locator(".toast")).to_contain_text("You have the lead")
    expect(admin.locator(".toast")).to_contain_text("ben has the lead")
    expect(admin.locator("#people li", has_text="ben")).to_contain_text("lead")
    wait_for_boxes(ben, [7, 6, *ALL_ON[2:]])
    ben.keyboard.press("u")
    expect(ben.locator(".toast")).to_contain_text("nothing to take back")
    ben.keyboard.type("5g")
    for page in (admin, ben):
        page.wait_for_function("text => stage.dataset.shown === text", arg=join(7, 6, 7, 7, 5))
    wait_for_boxes(admin, [7, 6, *ALL_ON[2:]])
    expect(ben.locator("#people tbody tr", has_text="admin")).to_be_visible()


def join(*robots: int) -> str:
    """All that is shown if the first robots show this and the rest everything."""
    return ",".join(map(str, [*robots, *ALL_ON[len(robots) :]]))


def wait_until_ticks_passed(page: Page, ticks: int) -> None:
    """Wait until the world went on for so long."""
    tick = int(facts(page)["tick"])
    page.wait_for_function("tick => Number(stage.dataset.tick) > tick", arg=tick + ticks)


def stop_and_download(page: Page) -> list[dict[str, str]]:
    """End the run by its menu; the dataset's rows."""
    page.get_by_text("About this run").click()
    page.get_by_text("Stop this run").click()
    page.get_by_role("button", name="Stop it for good").click()
    expect(page.get_by_role("heading", name="This run was stopped")).to_be_visible()
    with page.expect_download() as download:
        page.get_by_role("link", name="Download the dataset").click()
    return list(csv.DictReader(io.StringIO(download.value.path().read_text())))


def check_pairs(rows: list[dict[str, str]]) -> None:
    """The dataset holds what the lead of the moment had set, and nothing of the others."""
    seen: dict[int, list[int]] = {robot: [] for robot in range(6)}
    for row in rows:
        if row["agent_kind"] == "robot":
            seen[int(row["agent"])].append(int(row["box"]))
    assert {robot: set(boxes) for robot, boxes in seen.items()} == {
        robot: {1: {7, 6}, 4: {7, 5}}.get(robot, {7}) for robot in range(6)
    }
    assert all(boxes == sorted(boxes, reverse=True) for boxes in seen.values())


def check_agreement(page: Page, server: Server, run_id: str) -> None:
    """The page of the run that is over shows scikit-learn's kappa of the stored ratings."""
    rows = page.locator("#people tbody tr")
    expect(rows).to_have_count(2)
    stored = sqlite3.connect(f"file:{server.folder}/varil.sqlite3?mode=ro", uri=True)
    query = "SELECT expert, agent, mask, lead_mask, drawn FROM learning_ratings WHERE run_id = ?"
    ratings = stored.execute(query, (run_id,)).fetchall()
    stored.close()
    for row, expert in zip(rows.all(), ("ben", "admin"), strict=True):
        mine = [entry[1:] for entry in ratings if entry[0] == expert]
        expect(row.locator("th")).to_have_text(expert)
        said = [cell.split() for cell in row.locator("td").all_inner_texts()]
        for (kappa, _, n), bit in zip(said, BITS.values(), strict=False):
            drawn = [entry for entry in mine if entry[0] < 6 and entry[3] & bit]
            both = [[bool(entry[at] & bit) for entry in drawn] for at in (1, 2)]
            assert int(n) == len(drawn)
            if len({*both[0], *both[1]}) > 1:
                assert float(kappa) == pytest.approx(cohen_kappa_score(*both), abs=0.0051)
            else:
                assert kappa == "–"
