"""What an expert does on the page, in real Chromium against a scripted run.

Keys, mouse, storing, lost lines, refusals. The script's knobs bring about what a healthy server
seldom does.
"""

from __future__ import annotations

import time

from playwright.sync_api import Page, expect

from browser.conftest import Server
from browser.expert_page import (
    ALL_ON,
    boxes,
    cell,
    heard,
    turn,
    wait_for_boxes,
    wait_until_stored,
)


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
    frames = int(desk.locator("#stage").get_attribute("data-frames") or 0)
    desk.wait_for_function("before => Number(stage.dataset.frames) > before + 1", arg=frames)
    row = desk.locator("tr.chosen")
    expect(row).to_have_attribute("data-agent", "0")
    station = desk.locator("#stage > .view").bounding_box()
    assert station is not None
    desk.mouse.click(station["x"] + 200, station["y"] + station["height"] - 14)
    expect(row).not_to_have_attribute("data-agent", "0")
