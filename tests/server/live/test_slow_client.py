"""Guards that a client which reads slowly is sent the newest state, never a backlog."""

import asyncio
import socket
import struct
from typing import Any

from server.live import wire

from .line import HELLO, READY, Serving, pack


async def test_a_slow_client_gets_the_newest_state_only(serving: Serving) -> None:
    """Nobody reads for 4 s: then a few kilobytes arrive, and soon the present tick."""
    reader, writer = await open_raw(serving.port, "wide")
    room = await started_room(serving, "wide", writer)
    while room.world.tick < 100:
        writer.write(mask_frame(2, pack(1, (0, 0))))
        await asyncio.sleep(0.1)
    tick = room.world.tick
    ticks: list[int] = []
    async with asyncio.timeout(5):
        while not ticks or ticks[-1] < tick:
            opcode, payload = await read_frame(reader)
            if opcode == 2 and payload[0] == wire.SNAPSHOT:
                ticks.append(struct.unpack_from("<I", payload, 2)[0])
    writer.close()
    assert ticks == sorted(ticks)
    old = [t for t in ticks if t < tick - 15]
    assert len(old) * 88 < 24_000, "what waited was bounded"


async def started_room(serving: Serving, trial: str, writer: asyncio.StreamWriter) -> Any:
    writer.write(mask_frame(1, HELLO.encode()))
    async with asyncio.timeout(10):
        room = await serving.hall.enter(f"token-{trial}")
        while not room.is_joined:  # noqa: ASYNC110 - a room has no event
            await asyncio.sleep(0)
        writer.write(mask_frame(1, READY.encode()))
        while room.phase != "running":  # noqa: ASYNC110
            await asyncio.sleep(0)
    return room


async def open_raw(port: int, trial: str) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
    """A WebSocket by hand, with small buffers, that reads only when told to."""
    raw = socket.socket()
    raw.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    raw.setblocking(False)
    await asyncio.get_running_loop().sock_connect(raw, ("127.0.0.1", port))
    reader, writer = await asyncio.open_connection(sock=raw, limit=2048)
    writer.write(
        f"GET /p/token-{trial}/live HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n"
        "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n".encode()
    )
    assert (await reader.readuntil(b"\r\n\r\n")).startswith(b"HTTP/1.1 101")
    return reader, writer


def mask_frame(opcode: int, payload: bytes) -> bytes:
    """A client's frame with an all-zero mask."""
    return bytes((0x80 | opcode, 0x80 | len(payload))) + bytes(4) + payload


async def read_frame(reader: asyncio.StreamReader) -> tuple[int, bytes]:
    first, length = await reader.readexactly(2)
    if length == 126:
        (length,) = struct.unpack("!H", await reader.readexactly(2))
    elif length == 127:
        (length,) = struct.unpack("!Q", await reader.readexactly(8))
    return first & 15, await reader.readexactly(length)
