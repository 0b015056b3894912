"""Take pictures of the scene with a scripted world in real Chromium.

Run as `python -m tests.browser.make_pictures` with names of shots (`study-full-aisle`) to look at
the scene; `--docs` writes the README's pictures, `--elements` those of the explanation pages, and
`--bench` prints the JavaScript time per frame and the draw calls as JSON.
"""

from __future__ import annotations

import argparse
import base64
import functools
import http.server
import json
import shutil
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from playwright.sync_api import Browser, Page, sync_playwright

from tests.browser.scene.palette_png import encode
from tests.browser.scene.worlds import Eye, build_world

ROOT = Path(__file__).resolve().parents[2]
SCENE = Path(__file__).resolve().parent / "scene"
CHROMIUM_ARGS = [
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]


@dataclass(frozen=True)
class Shot:
    """Where a picture is taken from: metres, radians; and what is shown."""

    scale: str
    display: str
    x: float
    y: float
    heading: float
    pitch: float = 0.0
    now_s: float = 3.0
    seed: int = 11
    size: tuple[int, int] = (1280, 720)
    colours: int = 0
    hud: str = ""


SHOTS: dict[str, Shot] = {
    f"{scale}-{display}-{place}": Shot(scale, display, *at)
    for scale, places in {
        "study": {
            "aisle": (7.8, 2.6, 1.62, -0.03),
            "cross": (2.0, 10.8, 0.0, -0.03),
            "station": (21.0, 2.2, -0.5, -0.04),
            "corner": (1.4, 20.0, -0.55, -0.06),
            "homes": (23.4, 10.8, 0.1, -0.1),
        },
        "large": {
            "aisle": (24.0, 26.0, 0.1),
            "corner": (1.5, 1.8, 0.75),
            "cross": (20.0, 32.0, -1.2),
        },
    }.items()
    for display in ("none", "mixed", "arroch", "crmiar", "full", "everything")
    for place, at in places.items()
}
SHOTS["study-none-down"] = Shot("study", "none", 6.9, 5.1, 1.3, -0.6)
SHOTS["study-none-up"] = Shot("study", "none", 6.9, 5.1, 1.3, 0.5)

CROSS = (2.0, 10.8, 0.0, -0.05)
LONG_AISLE = (11.4, 10.4, 0.35, -0.14)
DOCS = {
    name: Shot("study", name, *at, now_s=2.2, seed=seed, colours=256, hud=hud)
    for name, at, seed, hud in (
        ("full", (1.4, 20.0, -0.55, -0.06), 11, "Display C"),
        ("arroch", (8.4, 10.4, 0.3, -0.1), 8, "Display A"),
        ("crmiar", (11.4, 10.4, 0.35, -0.1), 5, "Display B"),
    )
}
ELEMENTS = {
    name: Shot("study", name, *at, now_s=0.9, seed=seed, size=(960, 540), colours=200)
    for name, at, seed in (
        ("trajectory", LONG_AISLE, 5),
        ("live-location", (4.8, 10.8, 0.9, -0.08), 5),
        ("transparent-avatar", LONG_AISLE, 5),
        ("balloon", (14.6, 2.0, -0.04, 0.0), 11),
        ("minimap", CROSS, 11),
        ("offscreen-arrows", (13.8, 10.8, 0.0, -0.04), 11),
        ("path-beads", LONG_AISLE, 5),
        ("none", CROSS, 11),
    )
}


def bundle_page(folder: Path) -> None:
    """Bundle the picture page and the play page's styles into a folder."""
    esbuild = ROOT / "node_modules" / ".bin" / "esbuild"
    entries = [str(SCENE / "page.js"), f"page={ROOT / 'web/static/css/play.css'}"]
    options = ["--bundle", "--format=esm", "--target=es2022", "--log-level=warning"]
    subprocess.run(
        [str(esbuild), entries[0], *options, f"--outfile={folder / 'page.js'}"], check=True
    )
    css = str(ROOT / "web/static/css/play.css")
    subprocess.run(
        [str(esbuild), css, "--bundle", f"--outfile={folder / 'page.css'}", "--log-level=warning"],
        check=True,
    )
    shutil.copy(SCENE / "index.html", folder / "index.html")


class QuietHandler(http.server.SimpleHTTPRequestHandler):
    """Serves a folder without a line per request."""

    def log_message(self, *args: object) -> None:
        """Keep quiet."""


@contextmanager
def serve_folder(folder: Path) -> Iterator[str]:
    """Serve a folder on a free port; gives its address."""
    handler = functools.partial(QuietHandler, directory=str(folder))
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        yield f"http://127.0.0.1:{server.server_address[1]}/"
    finally:
        server.shutdown()


def report(record: dict[str, Any]) -> None:
    """Write one line of JSON."""
    sys.stdout.write(json.dumps(record) + "\n")
    sys.stdout.flush()


def open_world(browser: Browser, folder: Path, url: str, shot: Shot) -> Page:
    """Open the picture page with a shot's world."""
    world = build_world(shot.scale, shot.display, shot.seed, Eye(shot.x, shot.y, shot.heading))
    world["hud"] = shot.hud
    (folder / "world.json").write_text(json.dumps(world))
    page = browser.new_page(viewport={"width": shot.size[0], "height": shot.size[1]})
    page.on("console", lambda message: report({"console": message.text}))
    page.on("pageerror", lambda error: report({"page error": str(error)}))
    page.goto(url)
    page.wait_for_selector("body[data-ready]", state="attached", timeout=120_000)
    return page


def view_of(shot: Shot) -> dict[str, float]:
    """Return the viewpoint as the page takes it."""
    return {
        "x": shot.x,
        "y": shot.y,
        "heading": shot.heading,
        "pitch": shot.pitch,
        "now_s": shot.now_s,
    }


READ_PIXELS = """async (data) => {
  const file = await fetch("data:image/png;base64," + data);
  const image = await createImageBitmap(await file.blob());
  const pen = new OffscreenCanvas(image.width, image.height).getContext("2d");
  pen.drawImage(image, 0, 0);
  const bytes = pen.getImageData(0, 0, image.width, image.height).data;
  let text = "";
  for (let n = 0; n < bytes.length; n += 8192)
    text += String.fromCharCode(...bytes.subarray(n, n + 8192));
  return btoa(text);
}"""


def reduce_colours(page: Page, png: bytes, size: tuple[int, int], colours: int) -> bytes:
    """Return the same picture with a palette."""
    raw = base64.b64decode(page.evaluate(READ_PIXELS, base64.b64encode(png).decode()))
    pixels = np.frombuffer(raw, dtype=np.uint8).reshape(size[1], size[0], 4)[:, :, :3]
    return encode(np.ascontiguousarray(pixels), colours)


def take(browser: Browser, folder: Path, url: str, shot: Shot, target: Path) -> dict[str, Any]:
    """Take one picture; returns draw calls and triangles."""
    page = open_world(browser, folder, url, shot)
    counts: dict[str, Any] = page.evaluate("shot => window.picture.draw(shot)", view_of(shot))
    target.parent.mkdir(parents=True, exist_ok=True)
    png = page.screenshot(timeout=120_000)
    if shot.colours:
        png = reduce_colours(page, png, shot.size, shot.colours)
    target.write_bytes(png)
    page.close()
    return counts | {"kB": round(len(png) / 1000)}


def bench(browser: Browser, folder: Path, url: str) -> dict[str, Any]:
    """Measure JavaScript per frame and draw calls at `large` scale with everything shown."""
    shot = Shot("large", "everything", 19.0, 31.2, 0.1)
    page = open_world(browser, folder, url, shot)
    counts = page.evaluate("shot => window.picture.draw(shot)", view_of(shot))
    runs = [
        page.evaluate("shot => window.picture.measure(shot, 300)", view_of(shot)) for _ in range(5)
    ]
    medians = sorted(run["median_ms"] for run in runs)
    return {"drawn": counts, "median_ms": medians[2], "runs": runs}


def main() -> None:
    """Take what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--out", type=Path, default=Path(tempfile.gettempdir()) / "pictures")
    parser.add_argument("--docs", action="store_true")
    parser.add_argument("--elements", action="store_true")
    parser.add_argument("--bench", action="store_true")
    options = parser.parse_args()
    jobs: list[tuple[str, Shot, Path]] = [
        (n, SHOTS[n], options.out / f"{n}.png") for n in options.names
    ]
    if options.docs:
        jobs += [(n, s, ROOT / "docs" / "pictures" / f"{n}.png") for n, s in DOCS.items()]
    if options.elements:
        folder = ROOT / "web" / "static" / "img" / "elements"
        jobs += [(n, s, folder / f"{n}.png") for n, s in ELEMENTS.items()]
    with tempfile.TemporaryDirectory() as name, sync_playwright() as playwright:
        folder = Path(name)
        bundle_page(folder)
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), chromium_sandbox=False, args=CHROMIUM_ARGS
        )
        with serve_folder(folder) as url:
            for title, shot, target in jobs:
                report({"picture": title, **take(browser, folder, url, shot, target)})
            if options.bench:
                report(bench(browser, folder, url))
        browser.close()


if __name__ == "__main__":
    main()
