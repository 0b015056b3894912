"""Take the README's picture of the expert's page: a real server, a simulated worker, real keys.

Run as `python -m tests.browser.page_pictures`; it takes about a minute and a half.
"""

from __future__ import annotations

import os
import random
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager

from playwright.sync_api import Page, sync_playwright

from tests.browser.make_pictures import CHROMIUM_ARGS, ROOT, reduce_colours

PASSWORD = "pictures-are-not-secret"
SIZE = (1280, 720)
WORKED_S = 60.0
EDIT_EVERY_MS = 600
STARTS_WITHIN_S = 120.0


@contextmanager
def serve_demo() -> Iterator[str]:
    """A server of its own with the demo study in a throw-away folder; gives its address."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    with tempfile.TemporaryDirectory() as folder:
        environment = {
            **os.environ,
            "VARIL_VAR_DIR": folder,
            "VARIL_PORT": str(port),
            "VARIL_ADMIN_PASSWORD": PASSWORD,
        }
        command = [sys.executable, "-c", "from server.cli.main import main; main()", "serve"]
        process = subprocess.Popen(command, env=environment, cwd=ROOT, stdout=subprocess.DEVNULL)
        try:
            wait_for(f"http://127.0.0.1:{port}/healthz")
            yield f"http://127.0.0.1:{port}"
        finally:
            process.send_signal(signal.SIGINT)
            process.wait(timeout=30)


def wait_for(address: str) -> None:
    """Return once the address answers; TimeoutError after two minutes."""
    end_s = time.monotonic() + STARTS_WITHIN_S
    while time.monotonic() < end_s:
        try:
            urllib.request.urlopen(address, timeout=2).close()
        except OSError:
            time.sleep(0.2)
        else:
            return
    raise TimeoutError(f"{address} did not answer within {STARTS_WITHIN_S:.0f} s")


def show_run(page: Page, url: str) -> None:
    """Sign in, start a run with a simulated worker and correct its display for a minute."""
    page.goto(f"{url}/login")
    page.fill("#name", "admin")
    page.fill("#password", PASSWORD)
    page.get_by_role("button", name="Sign in").click()
    page.goto(f"{url}/expert")
    page.locator("select[name=worker]").select_option("simulated")
    page.get_by_role("button", name="Start the run").click()
    running = "() => Number(document.querySelector('#stage')?.dataset.frames) > 0"
    page.wait_for_function(running, timeout=180_000)
    draw = random.Random(3)
    for _ in range(round(WORKED_S * 1000 / EDIT_EVERY_MS)):
        page.keyboard.press("Escape")
        page.keyboard.type(f"{draw.randint(1, 12)}{draw.choice('tlg')}")
        page.wait_for_timeout(EDIT_EVERY_MS)
    page.wait_for_timeout(3000)


def main() -> None:
    """Take the picture."""
    with serve_demo() as url, sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), chromium_sandbox=False, args=CHROMIUM_ARGS
        )
        page = browser.new_page(viewport={"width": SIZE[0], "height": SIZE[1]})
        show_run(page, url)
        png = page.screenshot(timeout=120_000)
        blank = browser.new_page()
        target = ROOT / "docs" / "pictures" / "expert.png"
        target.write_bytes(reduce_colours(blank, png, SIZE, 256))
        browser.close()


if __name__ == "__main__":
    main()
