"""An administrator at work in real Chromium: watches, notes, excludes, replays, downloads.

The server is shared with other tests, so there may be more people than those made here.
"""

from __future__ import annotations

import re
import sqlite3
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, Page, expect

from browser.bystander import Bystander, take_part
from browser.conftest import ADMIN_PASSWORD, Server
from browser.joining import join_and_go_to
from study.records.tables import neutralise_formula
from tests.server.export.site import read_tables

DRAWN = "() => Number(document.querySelector('#stage')?.dataset.frames) > 2"
LATER = "tick => Number(document.querySelector('#stage').dataset.tick) > tick"
PHASE = "phase => document.querySelector('#stage').dataset.phase === phase"
WITHIN_MS = 30_000
NOTE = "=stands at the start"


@pytest.fixture(scope="module")
def admin(browser: Browser, practice_server: Server) -> Iterator[Page]:
    """The page of somebody signed in as an administrator; no script of it may fail."""
    context = browser.new_context(viewport={"width": 720, "height": 440})
    context.set_default_timeout(60_000)
    page = context.new_page()
    faults: list[str] = []
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.goto(f"{practice_server.url}/login")
    page.get_by_label("Name").fill("admin")
    page.get_by_label("Password").fill(ADMIN_PASSWORD)
    page.get_by_role("button", name="Sign in").click()
    expect(page).to_have_url(re.compile("/admin$"))
    yield page
    assert faults == []
    context.close()


@pytest.fixture(scope="module")
def finished(practice_server: Server) -> str:
    """The code of a simulated participant who has done everything."""
    return take_part(practice_server.url, "walk")


def ask(server: Server, query: str, *values: Any) -> list[tuple[Any, ...]]:
    """Rows of the server's database."""
    (file,) = server.folder.glob("*.sqlite3")
    with sqlite3.connect(f"file:{file}?mode=ro", uri=True) as database:
        return database.execute(query, values).fetchall()


def tick_of(page: Page) -> int:
    return int(page.locator("#stage").get_attribute("data-tick") or 0)


def check_with_axe(page: Page) -> None:
    """Nothing on the page bars anybody."""
    found = Axe().run(page).response["violations"]
    assert [(v["id"], [node["target"] for node in v["nodes"]]) for v in found] == []


def test_a_running_trial_is_watched_noted_and_given_more_time(
    admin: Page, practice_server: Server
) -> None:
    """It appears in the list by itself, is seen by every camera, and outlives its participant's
    absence; note and time are stored while the picture goes on."""
    page, server = admin, practice_server
    page.goto(f"{server.url}/admin/live?study=walk")
    address = join_and_go_to(server.url, "walk", "practice")
    code, bystander = newest(server), Bystander(address)
    row = page.locator(f"tr[data-code='{code}']")
    expect(row).to_contain_text("running", timeout=WITHIN_MS)
    expect(row).to_contain_text("connected")
    row.get_by_role("link", name=f"watch {code}").click()
    page.wait_for_function(DRAWN)
    page.wait_for_function(LATER, arg=tick_of(page) + 15)
    page.evaluate("() => { window.isSamePage = true; }")
    for camera in ("free", "worker", "above"):
        page.keyboard.press("v")
        expect(page.locator("#stage")).to_have_attribute("data-camera", camera)
    page.get_by_role("button", name="Free").click()
    frames = int(page.locator("#stage").get_attribute("data-frames") or 0)
    page.wait_for_function("n => Number(stage.dataset.frames) > n + 1", arg=frames)
    noted_at = write_note(page)
    check_with_axe(page)
    bystander.leave()
    page.wait_for_function(PHASE, arg="paused")
    expect(page.locator(".notices > .note")).to_contain_text("the participant is away")
    page.get_by_label("If away, wait longer").select_option("30")
    page.get_by_role("button", name="Extend").click()
    expect(page.locator(".toast")).to_contain_text("Waits 30 minutes longer", timeout=WITHIN_MS)
    assert page.evaluate("() => window.isSamePage"), "the picture was left"
    trial = page.url.rsplit("/", 1)[1]
    stored = ask(server, "SELECT tick, text FROM staff_notes WHERE trial_id = ?", trial)
    assert stored == [(noted_at, NOTE)]
    page.goto(f"{server.url}/admin/live?study=walk")
    expect(page.locator(f"tr[data-code='{code}']")).to_contain_text("of 5400 s", timeout=WITHIN_MS)


def newest(server: Server) -> str:
    """The code of whoever joined last."""
    return str(ask(server, "SELECT code FROM participants ORDER BY id DESC LIMIT 1")[0][0])


def write_note(page: Page) -> int:
    """A note is about the moment at which its first letter was typed; returns that tick."""
    field = page.locator("input[name=note]")
    field.press_sequentially(NOTE[:1])
    tick = int(page.locator("#note-form input[name=tick]").input_value())
    page.wait_for_function(LATER, arg=tick + 30)
    field.press_sequentially(NOTE[1:])
    page.get_by_role("button", name="Keep").click()
    expect(page.locator(".toast")).to_contain_text(
        f"Note kept at {tick / 30:.1f} s", timeout=WITHIN_MS
    )
    expect(field).to_have_value("")
    return tick


def overview(page: Page, server: Server) -> tuple[list[str], list[str]]:
    """The flow of simulated participants and the rows of the cells."""
    page.goto(f"{server.url}/admin?study=walk&mode=bot")
    table = page.get_by_role("region", name="Orders of the conditions")
    return page.locator(".flow > li").all_inner_texts(), table.locator("tbody tr").all_inner_texts()


def test_exclude_and_reinstate_change_flow_and_cells_there_and_back(
    admin: Page, practice_server: Server, finished: str
) -> None:
    """What the preview says is what happens, and taking it back leaves no trace in the counts."""
    page, server = admin, practice_server
    before = overview(page, server)
    analysed = int(before[0][-1].split()[0])
    story = f"{server.url}/admin/participants/{finished}"
    page.goto(story)
    panel = page.locator("section[aria-labelledby=act-heading]")
    order = re.search(r"Order (.*?): completed (\d+) → (\d+)", panel.inner_text())
    assert order is not None
    assert int(order[3]) == int(order[2]) - 1
    panel.get_by_label("Reason").fill("spoke with others")
    panel.get_by_role("button", name=f"Exclude {finished}").click()
    expect(page.locator(".lead .status")).to_have_text("excluded")
    expect(page.get_by_role("region", name="Lifecycle")).to_contain_text("spoke with others")
    flow, cells = overview(page, server)
    assert int(flow[-1].split()[0]) == analysed - 1
    assert "1 excluded" in " ".join(flow)
    (row,) = [row for row in cells if row.startswith(order[1])]
    assert row.split("\t")[1] == order[3]
    page.goto(story)
    expect(panel).to_contain_text(f"completed {order[3]} → {order[2]}")
    panel.get_by_label("Reason").fill("they only said hello")
    panel.get_by_role("button", name=f"Reinstate {finished}").click()
    expect(page.locator(".lead .status")).to_have_text("completed")
    assert overview(page, server) == before


def test_a_finished_trial_is_replayed_at_any_speed_from_any_moment(
    admin: Page, practice_server: Server, finished: str
) -> None:
    """Play, pause, speed, slider and arrow keys; the link of a note leads to its moment."""
    page, server = admin, practice_server
    page.goto(f"{server.url}/admin/participants/{finished}")
    page.get_by_role("link", name="replay trial-1").click()
    page.wait_for_function(DRAWN)
    expect(page.locator("#line")).to_have_text("Paused", timeout=WITHIN_MS)
    last = int(page.locator("#seek").get_attribute("max") or 0)
    (ticks,) = ask(server, "SELECT ticks FROM trials WHERE id = ?", page.url.rsplit("/", 1)[1])
    assert last == ticks[0] > 300
    check_with_axe(page)
    page.keyboard.press(" ")
    page.wait_for_function(LATER, arg=10)
    page.get_by_role("button", name="Pause").click()
    page.wait_for_function(PHASE, arg="paused")
    held = tick_of(page)
    page.keyboard.press("ArrowRight")
    page.wait_for_function(LATER, arg=held + 120)
    for tick in (last - 90, 30, last - 60):
        page.locator("#seek").fill(str(tick))
        page.wait_for_function("tick => Number(stage.dataset.tick) === tick", arg=tick)
    page.get_by_label("Speed").select_option("8")
    page.get_by_role("button", name="Play").click()
    page.wait_for_function(PHASE, arg="finished")
    expect(page.locator("#clock")).to_have_text(f"{last / 30:.1f} s of {last / 30:.1f} s")
    page.goto("about:blank")
    page.goto(f"{server.url}/admin/replay/{page_of(server, finished)}#tick=150")
    page.wait_for_function("() => Number(stage.dataset.tick) === 150")


def page_of(server: Server, code: str) -> str:
    """The participant's first trial."""
    query = (
        "SELECT t.id FROM trials t JOIN participants p ON p.id = t.participant_id"
        " WHERE p.code = ? AND t.position = 1"
    )
    return str(ask(server, query, code)[0][0])


def test_the_download_holds_its_manifest_and_equals_the_database(
    admin: Page, practice_server: Server, finished: str, tmp_path: Path
) -> None:
    """By the page's button: people, trials, answers, events and notes, neither more nor less."""
    page, server = admin, practice_server
    page.goto(f"{server.url}/admin/data?study=walk")
    page.get_by_label("With staff's notes").check()
    with page.expect_download() as download:
        page.get_by_role("button", name="Download the export").click()
    download.value.save_as(tmp_path / "walk.zip")
    tables = read_tables((tmp_path / "walk.zip").read_bytes())

    def told(table: str, *columns: str) -> list[tuple[str, ...]]:
        return sorted(tuple(row[name] for name in columns) for row in tables[table])

    def kept(columns: str, tables_and_rule: str) -> list[tuple[str, ...]]:
        rows = ask(server, f"SELECT {columns} FROM {tables_and_rule}")
        return sorted(
            tuple("" if cell is None else neutralise_formula(str(cell)) for cell in row)
            for row in rows
        )

    people = "participants p ON p.id = {}.participant_id WHERE p.status <> 'withdrawn'"
    assert told("participants", "participant_code", "status") == kept(
        "code, status", "participants"
    )
    rule = f"trials t JOIN {people.format('t')} AND t.kind = 'trial'"
    assert told("trials", "trial_id", "status", "ticks") == kept("t.id, t.status, t.ticks", rule)
    rule = f"responses r JOIN {people.format('r')}"
    columns = "p.code, r.step, r.item, r.value"
    assert told("responses", "participant_code", "step", "item", "value") == kept(columns, rule)
    rule = f"staff_notes n JOIN {people.format('n')}"
    columns = "p.code, n.trial_id, n.tick, n.text"
    assert told("notes", "participant_code", "trial_id", "tick", "text") == kept(columns, rule)
    rule = f"trial_events e JOIN trials t ON t.id = e.trial_id JOIN {people.format('t')}"
    events = kept("t.id, e.number, e.kind", f"{rule} AND t.kind = 'trial'")
    assert told("events", "trial_id", "number", "kind") == events
    assert len(events) > 20
    assert finished in {row["participant_code"] for row in tables["participants"]}
    (entry,) = ask(server, "SELECT user_name, action FROM audit ORDER BY id DESC LIMIT 1")
    assert entry == ("admin", "export downloaded")
