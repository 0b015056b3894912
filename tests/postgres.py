"""A real PostgreSQL server of our own, from the system's packages, to be stopped and started."""

from __future__ import annotations

import os
import pwd
import shutil
import socket
import subprocess
import tempfile
from pathlib import Path


class PostgresServer:
    """Its data lie in a folder of their own; `url` is its address without a database name."""

    def __init__(self, programs: Path) -> None:
        self._programs = programs
        self._account = "postgres" if os.geteuid() == 0 else None
        self._folder = Path(tempfile.mkdtemp(prefix="varil-postgres-"))
        if self._account:
            os.chown(self._folder, pwd.getpwnam(self._account).pw_uid, -1)
        self._port = free_port()
        self.url = f"postgresql://varil@127.0.0.1:{self._port}"

    def __enter__(self) -> PostgresServer:
        """Make the server's data and start it."""
        try:
            data = self._folder / "data"
            self._run([self._programs / "initdb", "-D", data, "-U", "varil", "-A", "trust", "-N"])
            self.start()
        except BaseException:
            shutil.rmtree(self._folder, ignore_errors=True)
            raise
        return self

    def __exit__(self, *exc: object) -> None:
        """Stop it and remove everything."""
        try:
            self.stop()
        finally:
            shutil.rmtree(self._folder, ignore_errors=True)

    def start(self) -> None:
        """Start, and return when it answers."""
        options = f"-p {self._port} -k {self._folder} -c listen_addresses=127.0.0.1 -c fsync=off"
        self._control("-o", options, "start")

    def stop(self) -> None:
        """Stop at once, as when the machine fails."""
        self._control("-m", "immediate", "stop")

    def _control(self, *words: str) -> None:
        folder = self._folder
        control = [self._programs / "pg_ctl", "-D", folder / "data", "-w", "-l", folder / "log"]
        self._run([*control, *words])

    def _run(self, words: list[str | Path]) -> None:
        """Run one of PostgreSQL's programs; it refuses to run as root, hence the account.

        Output goes to a file: the server inherits it, and a pipe would be held open for ever.
        """
        with tempfile.TemporaryFile("w+") as output:
            done = subprocess.run(
                words, user=self._account, cwd="/", stdout=output, stderr=output, check=False
            )
            output.seek(0)
            assert done.returncode == 0, f"{words[0]} failed:\n{output.read()}"


def find_programs() -> Path | None:
    """The folder of PostgreSQL's server programs; None where they are not installed."""
    found = sorted(Path("/usr/lib/postgresql").glob("*/bin/initdb"))
    on_path = shutil.which("initdb")
    if not found and on_path is None:
        return None
    return (found[-1] if found else Path(str(on_path))).parent


def free_port() -> int:
    """A port that nobody listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
