"""A browser for pages whose server is the app in the test's own process."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import Page, Route, sync_playwright
from starlette.testclient import TestClient


@pytest.fixture
def chromium_page(client: TestClient) -> Iterator[Page]:
    """A browser whose every request is answered by the app in this process."""

    def answer(route: Route) -> None:
        asked = urlsplit(route.request.url)
        kind = route.request.headers.get("content-type", "text/plain")
        got = client.request(
            route.request.method,
            f"{asked.path}?{asked.query}",
            content=route.request.post_data_buffer,
            headers={"content-type": kind},
            follow_redirects=True,
        )
        route.fulfill(status=got.status_code, headers=dict(got.headers), body=got.content)

    program = shutil.which("chromium") or shutil.which("google-chrome")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, chromium_sandbox=False)
        page = browser.new_page(viewport={"width": 1280, "height": 800})
        page.route("**/*", answer)
        yield page
        browser.close()
