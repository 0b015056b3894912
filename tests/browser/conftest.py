"""Real Chromium from the system's packages, and real servers in processes of their own."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, expect

from browser.expert_page import DRAW_NOTHING, LISTEN, open_calm_run
from browser.joining import join_and_go_to

ROOT = Path(__file__).parent.parent.parent
TAP = (Path(__file__).parent / "trial_tap.js").read_text()
ADMIN_PASSWORD = "a-password-for-tests"
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
FLAGS = (
    "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic",
    "--no-first-run", "--disable-background-networking", "--disable-component-update",
    "--disable-sync",
)  # fmt: skip


expect.set_options(timeout=30_000)  # software rendering on a busy machine is slow


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Browser tests come last: the browser's driver keeps an event loop running in this thread."""
    here = Path(__file__).parent
    for item in items:
        if item.path.is_relative_to(here):
            item.add_marker("browser")
    items.sort(key=lambda item: item.path.is_relative_to(here))


@pytest.fixture(scope="session")
def browser_type_launch_args() -> dict[str, Any]:
    """The system's Chromium, drawing in software."""
    found = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    assert found, "no Chromium on this machine; `make test` installs it"
    return {"executable_path": found, "chromium_sandbox": False, "args": list(FLAGS)}


@pytest.fixture(scope="session")
def browser_context_args() -> dict[str, Any]:
    """A small window: software rendering draws a few frames a second."""
    return {"viewport": {"width": 640, "height": 360}}


@dataclass(frozen=True)
class Server:
    """A running server: its address, its data folder, and the environment it was given."""

    url: str
    folder: Path
    environment: dict[str, str]
    process: subprocess.Popen[str]

    def varil(self, *words: str, stdin: str = "") -> str:
        """Run a `varil` verb on the same data; returns its output."""
        command = [str(Path(sys.executable).parent / "varil"), *words]
        done = subprocess.run(
            command,
            env=self.environment,
            input=stdin,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout


@pytest.fixture(scope="session")
def start_server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Callable[..., Server]]:
    """Starts servers; all of them end with the session."""
    running: list[subprocess.Popen[str]] = []

    def start(study: str, script: str = "serve_study.py", **settings: str) -> Server:
        folder = tmp_path_factory.mktemp(study)
        port = free_port()
        environment = {
            **os.environ,
            "VARIL_VAR_DIR": str(folder),
            "VARIL_PORT": str(port),
            "VARIL_ADMIN_PASSWORD": ADMIN_PASSWORD,
            **settings,
        }
        log = (folder / "server.log").open("w")
        process = subprocess.Popen(
            [sys.executable, str(ROOT / "tests/browser" / script), study],
            env=environment,
            cwd=ROOT,
            text=True,
            stdout=log,
            stderr=subprocess.STDOUT,
        )
        log.close()
        running.append(process)
        server = Server(f"http://127.0.0.1:{port}", folder, environment, process)
        wait_until_it_answers(server)
        return server

    yield start
    for process in running:
        process.send_signal(signal.SIGINT)
    for process in running:
        process.wait(timeout=20)


@pytest.fixture(scope="session")
def walk_server(start_server: Callable[..., Server]) -> Server:
    """The study for the walk, its world twice as fast as real time."""
    return start_server("walk", VARIL_TIME_SCALE="2")


@pytest.fixture(scope="session")
def practice_server(start_server: Callable[..., Server]) -> Server:
    """A study with small halls, in real time."""
    return start_server("walk")


@pytest.fixture(scope="session")
def learning_server(start_server: Callable[..., Server]) -> Server:
    """A server for live learning runs, whose worlds run four times as fast as real time."""
    return start_server("walk", VARIL_TIME_SCALE="4")


@pytest.fixture(scope="module")
def tapped_context(
    browser: Browser, browser_context_args: dict[str, Any]
) -> Iterator[BrowserContext]:
    """A browser profile whose pages let the tests hear their sockets."""
    fresh = browser.new_context(**browser_context_args)
    fresh.set_default_timeout(60_000)
    fresh.add_init_script(TAP)
    yield fresh
    fresh.close()


@pytest.fixture(scope="session")
def fake(start_server: Callable[..., Server]) -> Server:
    """A scripted learning run in the hall of the study: 12 robots, 4 stations."""
    return start_server("study", script="serve_fake_run.py")


@pytest.fixture(scope="module")
def desk_page(browser: Browser) -> Iterator[Page]:
    """A page of 1280 x 720 whose pictures stay empty, for what is not about the picture."""
    context = browser.new_context(viewport={"width": 1280, "height": 720})
    context.set_default_timeout(60_000)
    context.add_init_script(LISTEN + DRAW_NOTHING)
    yield context.new_page()
    context.close()


@pytest.fixture
def desk(desk_page: Page, fake: Server) -> Page:
    """The expert's page of the calm scripted run, with every box on and nothing waiting."""
    open_calm_run(desk_page, fake)
    return desk_page


@pytest.fixture
def address(practice_server: Server) -> str:
    """The address of a participant whose next step is the practice."""
    return join_and_go_to(practice_server.url, "walk", "practice")


@pytest.fixture
def fresh_page(tapped_context: BrowserContext) -> Iterator[Page]:
    """One more tab."""
    page = tapped_context.new_page()
    yield page
    page.close()


def wait_until_it_answers(server: Server, limit_s: float = 60.0) -> None:
    """Poll `/healthz`; on failure show what the server said."""
    deadline = time.monotonic() + limit_s
    while time.monotonic() < deadline and server.process.poll() is None:
        try:
            with urllib.request.urlopen(server.url + "/healthz", timeout=2) as answer:
                if answer.status == 200:
                    return
        except (urllib.error.URLError, TimeoutError, ConnectionError):
            time.sleep(0.05)
    pytest.fail(f"the server did not answer: {(server.folder / 'server.log').read_text()}")


def free_port() -> int:
    """A port that nobody listens on at the moment."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
