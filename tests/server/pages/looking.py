"""What axe and a narrow window find wrong with the page that a browser shows."""

from __future__ import annotations

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page


def problems_of(page: Page) -> list[str]:
    """Names of the rules that are broken, and of the widths that the page does not fit."""
    found = [str(violation["id"]) for violation in Axe().run(page).response["violations"]]
    for width in (320, 640):
        page.set_viewport_size({"width": width, "height": 600})
        if page.evaluate("document.documentElement.scrollWidth") > width:
            found.append(f"wider than {width} px")
    page.set_viewport_size({"width": 1280, "height": 800})
    return found
