"""A server in a process of its own that can be killed and started again; the study it serves."""

from __future__ import annotations

import asyncio
import os
import signal
import subprocess
import sys
import urllib.error
import urllib.request
from pathlib import Path

from server.settings import Settings

ROOT = Path(__file__).parents[2]
VARIL = Path(sys.executable).parent / "varil"
PASSWORD = "a-password-for-drills"
UP_WITHIN_S = 120.0


class ServerProcess:
    """`varil serve` in a process of its own, on one port and one database over all its lives."""

    def __init__(self, folder: Path, port: int, study: Path, database_url: str = "") -> None:
        self.settings = Settings(
            var_dir=folder, port=port, database_url=database_url, study_files=(study,)
        )
        self.url = f"http://127.0.0.1:{port}"
        self._study = study
        self._folder = folder
        self._process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        """Start it; it answers a little later."""
        settings = {
            "VARIL_VAR_DIR": str(self._folder),
            "VARIL_ADMIN_PASSWORD": PASSWORD,
            "VARIL_DATABASE_URL": self.settings.database_url,
        }
        words = [VARIL, "serve", "--port", str(self.settings.port), "--study", self._study]
        with (self._folder / "server.log").open("ab") as log:
            self._process = subprocess.Popen(
                words, env=os.environ | settings, cwd=ROOT, stdout=log, stderr=log
            )

    def end(self, how: signal.Signals) -> None:
        """End it and wait until it is gone."""
        if self._process is not None:
            self._process.send_signal(how)
            self._process.wait(timeout=30)

    def status_of(self, path: str) -> int:
        """What an address answers; 0 if nobody does."""
        try:
            with urllib.request.urlopen(self.url + path, timeout=10) as answer:
                return int(answer.status)
        except urllib.error.HTTPError as error:
            return error.code
        except OSError:
            return 0

    def migrate(self) -> None:
        """Bring a database that is shared with others to the current schema."""
        words = [VARIL, "migrate", "--database-url", self.settings.database_url]
        subprocess.run(words, check=True, capture_output=True, cwd=ROOT)

    async def wait_until(self, path: str, status: int) -> None:
        """Return when an address answers so; raises TimeoutError."""
        async with asyncio.timeout(UP_WITHIN_S):
            while True:
                if await asyncio.to_thread(self.status_of, path) == status:
                    return
                await asyncio.sleep(0.1)


def write_study(folder: Path, hall: str) -> Path:
    """A study file for the drill: the demo study in one hall."""
    subprocess.run([VARIL, "init", folder / "drill"], check=True, capture_output=True, cwd=ROOT)
    file = folder / "drill" / "study.toml"
    text = file.read_text(encoding="utf-8")
    file.write_text(text.replace('\nscale = "study"', f'\nscale = "{hall}"', 1), encoding="utf-8")
    return file
