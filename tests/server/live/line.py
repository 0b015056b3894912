"""A participant's end of the line: what tests say over real sockets and wait to hear."""

import asyncio
import contextlib
import json
import struct
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed

from server.live import wire
from server.live.hall import Hall

from .stage import MemoryDesk

HELLO = json.dumps({"type": "hello", "version": 1})
READY = json.dumps({"type": "ready"})


@dataclass
class Serving:
    """A real server on a free port with some trials."""

    hall: Hall
    desk: MemoryDesk
    port: int

    def connect(self, trial: str, **settings: Any) -> connect:
        return connect(
            f"ws://127.0.0.1:{self.port}/p/token-{trial}/live", compression=None, **settings
        )


async def read_text(ws: ClientConnection, kind: str) -> dict[str, Any]:
    """The next text message of this type."""
    async with asyncio.timeout(10):
        while True:
            frame = await ws.recv()
            if isinstance(frame, str):
                message: dict[str, Any] = json.loads(frame)
                if message["type"] == kind:
                    return message


async def read_phase(ws: ClientConnection, phase: str) -> dict[str, Any]:
    while True:
        message = await read_text(ws, "phase")
        if message["phase"] == phase:
            return message


async def read_snapshot(ws: ClientConnection, fits: Callable[[int, int], bool]) -> float:
    """The human's x in the first snapshot whose tick and acknowledged number fit."""
    async with asyncio.timeout(10):
        while True:
            frame = await ws.recv()
            if isinstance(frame, bytes) and frame[0] == wire.SNAPSHOT:
                _, _, tick, acknowledged, x = struct.unpack_from("<BBIHH", frame)
                if fits(tick, acknowledged):
                    return float(x / 512)


async def start(ws: ClientConnection) -> dict[str, Any]:
    """Speak until the world runs; returns the welcome."""
    await ws.send(HELLO)
    welcome = await read_text(ws, "welcome")
    await ws.send(READY)
    await read_phase(ws, "running")
    return welcome


async def read_close(ws: ClientConnection) -> tuple[int, str]:
    with contextlib.suppress(ConnectionClosed):
        async with asyncio.timeout(10):
            while True:
                await ws.recv()
    assert ws.close_code is not None
    return ws.close_code, ws.close_reason or ""


def pack(seq: int, *frames: tuple[int, int]) -> bytes:
    body = b"".join(struct.pack("<BH", *frame) for frame in frames)
    return struct.pack("<BIB", 1, seq, len(frames)) + body
