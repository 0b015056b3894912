"""Browsers that cannot show the warehouse say what to do; one without cookies misses nothing."""

from __future__ import annotations

import re

from playwright.sync_api import BrowserContext, Page, expect

from browser.conftest import Server
from browser.joining import join_and_go_to, wait_for_running

WITHOUT_WEBGL = """
const real = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...options) {
  return String(kind).startsWith("webgl") ? null : real.call(this, kind, ...options);
};
"""
TOUCH_ONLY = """
Object.defineProperty(navigator, "maxTouchPoints", { value: 5 });
const real = window.matchMedia.bind(window);
window.matchMedia = (query) =>
  /pointer: *fine/.test(query) ? { ...real("not all"), matches: false } : real(query);
"""


def test_without_webgl_both_pages_say_what_to_do(
    practice_server: Server, fresh_page: Page, address: str
) -> None:
    page = fresh_page
    page.add_init_script(WITHOUT_WEBGL)
    page.goto(address)
    expect(page.get_by_role("heading", name="3D graphics are not available")).to_be_visible()
    expect(page.locator("#stage")).to_contain_text("switch on hardware acceleration")
    check_that_the_device_is_refused(
        page, practice_server, "WebGL 2 is missing", "in another browser"
    )


def test_a_touch_only_device_is_told_to_use_a_computer(
    practice_server: Server, fresh_page: Page, address: str
) -> None:
    page = fresh_page
    page.add_init_script(TOUCH_ONLY)
    page.goto(address)
    expect(page.get_by_role("heading", name="Please use a computer")).to_be_visible()
    assert page.evaluate("() => tap.sockets.length") == 0
    check_that_the_device_is_refused(
        page, practice_server, "only a touch screen", "with a keyboard and"
    )


def check_that_the_device_is_refused(
    page: Page, practice_server: Server, seen: str, advice: str
) -> None:
    """The browser check names the problem and says what to do; the participant stays there."""
    page.goto(join_and_go_to(practice_server.url, "walk", "browser-check"))
    expect(page.locator("#check-results")).to_contain_text(seen)
    page.locator("main button[type=submit]").click()
    expect(page.locator("#summary")).to_contain_text(advice)
    expect(page.locator("#check")).to_be_visible()


def test_the_whole_way_needs_no_cookie(
    practice_server: Server, tapped_context: BrowserContext, fresh_page: Page, address: str
) -> None:
    page = fresh_page
    tapped_context.new_cdp_session(page).send(
        "Emulation.setDocumentCookieDisabled", {"disabled": True}
    )
    page.goto(f"{practice_server.url}/s/walk")
    page.locator("main button[type=submit]").click()
    expect(page).to_have_url(re.compile(r"/p/[\w-]{20,}$"))
    assert tapped_context.cookies() == []
    page.goto(address)
    wait_for_running(page)
    assert tapped_context.cookies() == []
