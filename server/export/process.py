"""An export for download, made by a process of its own: no running trial waits for it."""

from __future__ import annotations

import asyncio
import contextlib
import os
import sys
from collections.abc import AsyncGenerator

from server.export.bundle import ExportOptions
from server.settings import Settings
from server.store.engine import StorageAway

PIECE_BYTES = 64 * 1024
NICENESS = 10
_COMMAND = "from server.cli.main import main; main()"


class ExportFailed(RuntimeError):
    """The export broke off; what was sent of it is no usable zip."""


async def begin_export(settings: Settings, options: ExportOptions) -> AsyncGenerator[bytes, None]:
    """Pieces of the zip. Returns once the first is there; raises `StorageAway` if none comes.

    Whoever stops reading ends the process. One that breaks off later raises `ExportFailed`, so
    that the download is cut and the receiver notices.
    """
    words = ["export", "--study", options.study_id, "--out", "-"]
    words += ["--mode", options.mode] if options.mode else []
    words += ["--telemetry"] if options.telemetry else []
    words += ["--panel-ids"] if options.panel_ids else []
    words += ["--notes"] if options.notes else []
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        "-c",
        _COMMAND,
        *words,
        env={**os.environ, "VARIL_DATABASE_URL": settings.database},
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.PIPE,
    )
    with contextlib.suppress(OSError, AttributeError):
        os.setpriority(os.PRIO_PROCESS, process.pid, NICENESS)
    pieces = _read(process)
    try:
        first = await anext(pieces)
    except (ExportFailed, StopAsyncIteration) as error:
        raise StorageAway from error
    return _chain(first, pieces)


async def _chain(first: bytes, pieces: AsyncGenerator[bytes, None]) -> AsyncGenerator[bytes, None]:
    async with contextlib.aclosing(pieces):
        yield first
        async for piece in pieces:
            yield piece


async def _read(process: asyncio.subprocess.Process) -> AsyncGenerator[bytes, None]:
    out = process.stdout
    try:
        while out is not None and (piece := await out.read(PIECE_BYTES)):
            yield piece
        if await process.wait() != 0:
            raise ExportFailed(f"the export ended with code {process.returncode}")
    finally:
        if process.returncode is None:
            process.kill()
            await process.wait()
