"""The trial's page in real Chromium when things go wrong around it.

Lost keyboard, refresh, dropped line, second tab, lost graphics, foreign keyboards. What the world
did is read from the server's own snapshots, not from the page.
"""

from __future__ import annotations

import math

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import BrowserContext, Page, expect

from browser.conftest import Server
from browser.joining import join_and_go_to, wait_for_running

TICK_HZ = 30
STOPS_WITHIN_TICKS = 12
HIDE = """hidden => {
  Object.defineProperty(document, "visibilityState", {
    value: hidden ? "hidden" : "visible", configurable: true });
  document.dispatchEvent(new Event("visibilitychange"));
}"""


@pytest.fixture(scope="module")
def shared_page(tapped_context: BrowserContext) -> Page:
    """A tab that several tests play in, because opening the hall takes long in software."""
    return tapped_context.new_page()


@pytest.fixture
def trial(shared_page: Page, practice_server: Server) -> Page:
    """A page on which a practice runs; a new participant's where the last one is used up."""
    is_fresh = """() => document.querySelector("#stage")?.dataset.phase === "running"
        && document.querySelector("#stage").dataset.connection === "open"
        && tap.places.at(-1)?.tick < 1500"""
    if not shared_page.evaluate(is_fresh):
        shared_page.goto(join_and_go_to(practice_server.url, "walk", "practice"))
        wait_for_running(shared_page)
    return shared_page


def last_place(page: Page) -> dict[str, float]:
    """Tick and place of the human in the newest snapshot; metres."""
    place: dict[str, float] = page.evaluate("() => tap.places.at(-1)")
    return place


def wait_for_tick(page: Page, tick: float) -> None:
    page.wait_for_function("tick => tap.places.at(-1).tick >= tick", arg=tick)


def wait_for_walk(page: Page, metres: float = 0.25) -> None:
    """Wait until the human is so far from where it is now."""
    start = last_place(page)
    page.wait_for_function(
        "([x, y, far]) => Math.hypot(tap.places.at(-1).x - x, tap.places.at(-1).y - y) > far",
        arg=[start["x"], start["y"], metres],
    )


def check_that_the_human_stops(page: Page, script: str, argument: object = None) -> None:
    """Run a script in the page while the human walks; soon after, and for a second, it stands."""
    tick = page.evaluate(
        f"argument => {{ ({script})(argument); return tap.places.at(-1).tick }}", argument
    )
    until = tick + STOPS_WITHIN_TICKS + TICK_HZ
    wait_for_tick(page, until)
    places = page.evaluate("from => tap.places.filter(p => p.tick >= from)", tick)
    late = {(p["x"], p["y"]) for p in places if p["tick"] >= tick + STOPS_WITHIN_TICKS}
    assert len(late) == 1, f"still walking: {places}"


def start_walking(page: Page) -> None:
    """Hold W until the human walks."""
    page.keyboard.down("w")
    wait_for_walk(page)


def walk_to_and_fro(page: Page) -> None:
    """The page takes keys as it should, and the human ends about where it was."""
    for key in ("w", "s"):
        page.keyboard.down(key)
        wait_for_walk(page)
        page.keyboard.up(key)


def test_a_page_that_loses_the_keyboard_lets_go_of_the_keys(trial: Page) -> None:
    start_walking(trial)
    check_that_the_human_stops(trial, "() => window.dispatchEvent(new Event('blur'))")
    trial.keyboard.up("w")
    trial.mouse.click(320, 180)
    trial.wait_for_function("() => document.pointerLockElement !== null")
    trial.keyboard.down("s")
    wait_for_walk(trial)
    check_that_the_human_stops(trial, "() => document.exitPointerLock()")
    trial.keyboard.up("s")


def test_a_hidden_page_lets_go_of_the_keys_and_shown_again_goes_on(trial: Page) -> None:
    start_walking(trial)
    before = last_place(trial)
    trial.evaluate(HIDE, True)
    trial.keyboard.up("w")
    trial.evaluate(HIDE, False)
    wait_for_tick(trial, before["tick"] + TICK_HZ)
    after = last_place(trial)
    gone_m = math.dist((before["x"], before["y"]), (after["x"], after["y"]))
    assert gone_m < 1.4 * STOPS_WITHIN_TICKS / TICK_HZ
    trial.keyboard.down("s")
    wait_for_walk(trial)
    trial.keyboard.up("s")


def test_help_lets_go_of_the_keys_which_count_again_once_it_is_closed(trial: Page) -> None:
    """At once, not a frame later: a key held since before would go unheard."""
    start_walking(trial)
    key = "code => window.dispatchEvent(new KeyboardEvent('keydown', { code, bubbles: true }))"
    check_that_the_human_stops(trial, key, "KeyH")
    trial.keyboard.up("w")
    expect(trial.get_by_role("dialog")).to_be_visible()
    trial.evaluate(f"() => ['KeyH', 'KeyS'].forEach({key})")
    wait_for_walk(trial)
    trial.keyboard.press("s")


def test_keys_count_by_their_place_and_q_and_e_turn(trial: Page) -> None:
    """On a French keyboard the key W's place types z; arrow keys walk as well."""
    send = """([type, code, key]) =>
        window.dispatchEvent(new KeyboardEvent(type, { code, key, bubbles: true }))"""
    start = last_place(trial)
    trial.evaluate(send, ["keydown", "KeyW", "z"])
    wait_for_walk(trial)
    forward = direction(start, last_place(trial))
    check_that_the_human_stops(trial, send, ["keyup", "KeyW", "z"])
    start = last_place(trial)
    trial.keyboard.down("ArrowDown")
    wait_for_walk(trial)
    trial.keyboard.up("ArrowDown")
    back = direction(start, last_place(trial))
    assert abs(math.remainder(back - forward - math.pi, 2 * math.pi)) < 0.1

    yaw = "() => Number(document.querySelector('#stage').dataset.yaw)"
    turned = f"""([from, sign]) => {{
        const by = (({yaw})() - from + 98304) % 65536 - 32768;
        return by * sign > 2000;
    }}"""
    for key, sign in (("q", 1), ("e", -1)):
        from_yaw = trial.evaluate(yaw)
        trial.keyboard.down(key)
        trial.wait_for_function(turned, arg=[from_yaw, sign])
        trial.keyboard.up(key)


def direction(start: dict[str, float], end: dict[str, float]) -> float:
    return math.atan2(end["y"] - start["y"], end["x"] - start["x"])


def test_a_refresh_resumes_the_running_trial_after_a_countdown(trial: Page) -> None:
    wait_for_tick(trial, TICK_HZ)
    before = last_place(trial)
    trial.reload()
    expect(trial.locator(".count")).to_be_visible(timeout=30_000)
    wait_for_running(trial)
    welcomes, phases = trial.evaluate("() => [tap.welcomes, tap.phases]")
    assert len(welcomes) == 1
    assert welcomes[0] >= before["tick"] - TICK_HZ
    assert phases[-2:] == ["countdown", "running"]
    wait_for_tick(trial, welcomes[0] + 10)


def test_a_dropped_line_pauses_the_world_and_comes_back_by_itself(
    trial: Page, tapped_context: BrowserContext
) -> None:
    wait_for_tick(trial, TICK_HZ)
    stage = trial.locator("#stage")
    sockets = trial.evaluate("() => tap.sockets.length")
    trial.evaluate("() => tap.sockets.at(-1).close()")  # first: offline, no close would be heard
    tapped_context.set_offline(True)
    try:
        expect(stage).to_have_attribute("data-connection", "lost")
        expect(trial.get_by_role("heading", name="Connection lost")).to_be_visible()
        dropped_at = last_place(trial)["tick"]
        trial.wait_for_function("n => tap.sockets.length >= n + 2", arg=sockets)
    finally:
        tapped_context.set_offline(False)
    expect(stage).to_have_attribute("data-connection", "open")
    wait_for_running(trial)
    resumed_at = trial.evaluate("() => tap.welcomes.at(-1)")
    assert dropped_at <= resumed_at <= dropped_at + TICK_HZ, "the world went on without anybody"
    wait_for_tick(trial, resumed_at + 10)
    walk_to_and_fro(trial)


def test_a_newer_tab_takes_over_and_the_older_does_not_fight(trial: Page, fresh_page: Page) -> None:
    newer = fresh_page
    before = trial.evaluate("() => tap.sockets.length")
    newer.goto(trial.url)
    wait_for_running(newer)
    expect(trial.get_by_role("heading", name="You went on in another tab")).to_be_visible()
    expect(trial.locator("#stage")).to_have_attribute("data-connection", "taken-over")
    wait_for_tick(newer, last_place(newer)["tick"] + TICK_HZ)
    assert trial.evaluate("() => tap.sockets.length") == before
    assert newer.evaluate("() => tap.sockets.length") == 1
    assert newer.evaluate("() => tap.phases.slice(-1)") == ["running"]


def test_a_lost_graphics_context_is_survived(trial: Page) -> None:
    canvas = trial.locator("#stage > .view")
    assert len(canvas.screenshot()) > 20_000
    trial.evaluate(
        """() => {
        const gl = document.querySelector("#stage > .view").getContext("webgl2");
        window.taken = gl.getExtension("WEBGL_lose_context");
        window.taken.loseContext();
    }"""
    )
    expect(trial.get_by_role("heading", name="The graphics stopped")).to_be_visible()
    trial.evaluate("() => window.taken.restoreContext()")
    expect(trial.locator(".overlay[data-kind='context-lost']")).to_be_hidden()
    frames = "() => Number(document.querySelector('#stage').dataset.frames)"
    trial.wait_for_function(f"before => ({frames})() > before + 1", arg=trial.evaluate(frames))
    assert len(canvas.screenshot()) > 20_000, "the picture did not come back"
    walk_to_and_fro(trial)


def test_the_view_fills_the_window_at_every_size(trial: Page) -> None:
    fits = """([width, height]) => {
        const canvas = document.querySelector("#stage > .view");
        const box = canvas.getBoundingClientRect();
        return box.left === 0 && box.top === 0 && box.width === width && box.height === height
            && Math.abs(canvas.width / canvas.height - width / height) < 0.02;
    }"""
    for width, height in ((900, 300), (400, 500), (640, 360)):
        trial.set_viewport_size({"width": width, "height": height})
        trial.wait_for_function(fits, arg=[width, height])
        assert trial.evaluate(
            "() => document.documentElement.scrollWidth <= innerWidth"
            " && document.documentElement.scrollHeight <= innerHeight"
        )


def test_axe_finds_nothing_on_the_trial_page(trial: Page) -> None:
    for heading in ("", "How to move"):
        if heading:
            trial.keyboard.press("h")
            expect(trial.get_by_role("heading", name=heading)).to_be_visible()
        found = Axe().run(trial).response["violations"]
        assert [violation["id"] for violation in found] == []
    trial.keyboard.press("h")
