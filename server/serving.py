"""Running the server: claim the port and the database, say where to go, then answer.

The port is bound before anything is written, so that a port in use stops the start at once; the
addresses are printed before the socket accepts.
"""

from __future__ import annotations

import asyncio
import logging
import socket
import sys
from collections.abc import Sequence
from contextlib import closing

import uvicorn

from server.app import create_app
from server.desks.accounts import ensure_admin
from server.desks.policies import PolicyDesk
from server.desks.study_versions import register_versions
from server.live.line import LineProtocol
from server.locations import web_root
from server.pages.rendering import Renderer
from server.settings import Settings
from server.store.engine import Database, serve_alone
from server.store.schema import check_schema, migrate
from server.study_files import ReadStudy
from study.config import Study
from study.errors import StudyError

LOOPBACK = {"0.0.0.0": "127.0.0.1", "::": "[::1]"}  # noqa: S104 - what to print, not to bind


class PortInUse(StudyError):
    """Something else listens at the address."""

    def __init__(self, host: str, port: int, reason: str) -> None:
        super().__init__(
            f"cannot listen on {host}:{port} ({reason})",
            next_step="Stop what runs there, or choose another port with --port or VARIL_PORT.",
        )


def serve(settings: Settings, studies: Sequence[ReadStudy]) -> None:
    """Serve until stopped. Raises StudyError for everything the caller can mend."""
    logging.basicConfig(level=logging.WARNING, format="%(message)s")
    logging.getLogger("server").setLevel(logging.INFO)
    with closing(bind(settings.host, settings.port)) as listener:
        runner = asyncio.Runner(loop_factory=_loop_factory())
        with runner:
            runner.run(_serve(settings, studies, listener))


def bind(host: str, port: int) -> socket.socket:
    """A bound socket; raises `PortInUse` with the system's reason."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    listener = socket.socket(family, socket.SOCK_STREAM)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((host, port))
        listener.listen(2048)
    except OSError as error:
        listener.close()
        raise PortInUse(host, port, error.strerror or str(error)) from error
    listener.set_inheritable(True)
    return listener


async def _serve(settings: Settings, read: Sequence[ReadStudy], listener: socket.socket) -> None:
    Renderer(web_root()).assets.check()
    studies = [entry.study for entry in read]
    app = create_app(settings, studies)
    password = await _prepare(settings, read)
    _announce(settings.host, listener.getsockname()[1], studies, password)
    config = uvicorn.Config(
        app,
        ws=LineProtocol,
        ws_per_message_deflate=False,
        ws_max_size=8192,
        log_level="warning",
        access_log=False,
        server_header=False,
        log_config=None,
        proxy_headers=bool(settings.trusted_proxy),
        forwarded_allow_ips=settings.trusted_proxy,
        timeout_graceful_shutdown=5,
    )
    await uvicorn.Server(config).serve(sockets=[listener])


async def _prepare(settings: Settings, read: Sequence[ReadStudy]) -> str | None:
    """Refuse a database that is in use or of another version; make the first administrator.

    Says which versions are served, and what is doubtful about their policies. Returns the
    administrator's password if it was drawn just now. The app takes the lock again for as long as
    it runs.
    """
    database = Database(settings.database)
    try:
        async with serve_alone(database):
            await _prepare_schema(database)
            for sentence in await register_versions(database, read):
                say(sentence)
            desk = PolicyDesk(database, {entry.study.study_id: entry.study for entry in read})
            for warning in await desk.list_warnings():
                say(f"Warning: {warning}")
            return await ensure_admin(database, settings)
    finally:
        await database.close()


async def _prepare_schema(database: Database) -> None:
    """An embedded database is brought up to date; a shared one is left to `varil migrate`."""
    if database.file is None:
        await check_schema(database)
        return
    before, after = await migrate(database)
    if before != after:
        say(f"Database {database.file}: schema {before or 'none'} -> {after}")


def _announce(host: str, port: int, studies: Sequence[Study], password: str | None) -> None:
    base = f"http://{LOOPBACK.get(host, host)}:{port}"
    for study in studies:
        say(f"Participants join “{study.title}” at  {base}/s/{study.study_id}")
    say(f"Experts sign in at                 {base}/expert")
    say(f"Experimenters sign in at           {base}/admin")
    if password is not None:
        say(f"First administrator: name admin, password {password}  (shown only this once)")
    say("Stop with Ctrl-C.")


def say(line: str) -> None:
    """One line for the person at the terminal, at once."""
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def _loop_factory() -> type[asyncio.AbstractEventLoop] | None:
    if sys.platform == "win32":
        return None
    import uvloop

    return uvloop.Loop
