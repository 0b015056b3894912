"""Guards the endpoint over real sockets: handshake, states, codes, slow and hostile clients."""

import asyncio
import contextlib
import json
import random
import socket
import struct
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass, replace
from typing import Any

import pytest
import uvicorn
from starlette.applications import Starlette
from starlette.datastructures import Headers
from starlette.routing import WebSocketRoute
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from server.live import wire
from server.live.clock import SystemClock
from server.live.endpoint import LiveEndpoint
from server.live.hall import Hall

from .stage import SETUP, MemoryDesk

HELLO = json.dumps({"type": "hello", "version": 1})
READY = json.dumps({"type": "ready"})


async def be_ready() -> None:
    """The kernels are there already."""


def own_pages(headers: Headers) -> bool:
    return headers.get("origin") in (None, "http://127.0.0.1")


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


@pytest.fixture
async def serving() -> AsyncIterator[Serving]:
    names = [f"t-{number}" for number in range(1, 7)]
    setups = [replace(SETUP, trial_id=name, time_scale=4.0) for name in names]
    setups += [replace(SETUP, trial_id="wide", scale="study", condition="full", time_scale=1.0)]
    desk = MemoryDesk(*setups)
    hall = Hall(desk, be_ready, SystemClock())
    app = Starlette(routes=[WebSocketRoute("/p/{token}/live", LiveEndpoint(hall, own_pages))])
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        listener.listen(64)
        config = uvicorn.Config(
            app,
            ws="websockets-sansio",
            ws_per_message_deflate=False,
            ws_max_size=8192,
            log_level="error",
            lifespan="off",
            timeout_graceful_shutdown=2,
        )
        server = uvicorn.Server(config)
        server.install_signal_handlers = lambda: None  # type: ignore[attr-defined]
        running = asyncio.create_task(server.serve(sockets=[listener]))
        await hall.start()
        try:
            yield Serving(hall, desk, listener.getsockname()[1])
        finally:
            await hall.stop()
            server.should_exit = True
            await asyncio.wait_for(running, 10)


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


async def test_a_walk_over_a_real_socket(serving: Serving) -> None:
    """Input moves the human, snapshots acknowledge it, pongs answer, the trial is journaled."""
    async with serving.connect("t-1", origin="http://127.0.0.1") as ws:
        welcome = await start(ws)
        assert welcome["acknowledged_seq"] == 0
        await ws.send(json.dumps({"type": "ping", "sent_ms": 12.25}))
        assert await read_text(ws, "pong") == {"type": "pong", "sent_ms": 12.25}
        await read_snapshot(ws, lambda tick, acknowledged: tick >= 40)
        for seq in range(1, 41, 8):
            await ws.send(pack(seq, *[(1, 0)] * 8))
        x_m = await read_snapshot(ws, lambda tick, acknowledged: acknowledged == 40)
        assert x_m - welcome["human"]["x_m"] == pytest.approx(40 * 1.4 / 30, abs=0.01)
    await serving.hall.writer.flush()
    assert "started" in serving.desk.kinds("t-1")


@pytest.mark.parametrize(
    ("frames", "code", "reason"),
    [
        ([READY], 4400, "wanted “hello” first, got ready"),
        ([pack(1, (1, 0))], 4400, "wanted “hello” first, got input"),
        (['{"type":"hello","version":2}'], 4400, "wanted protocol version 1 (reload the page)"),
        ([HELLO, HELLO], 4400, "wanted “hello” once"),
        ([HELLO, pack(1, (1, 0))], 4400, "wanted “ready” before any input"),
        (["nonsense"], 4400, "wanted a JSON object"),
        ([HELLO, "x" * 300], 1009, "wanted at most 256 bytes, got 300 characters"),
        ([HELLO, bytes(300)], 1009, "wanted at most 256 bytes, got 300 bytes"),
    ],
)
async def test_what_does_not_fit_is_refused(
    serving: Serving, frames: list[str | bytes], code: int, reason: str
) -> None:
    """A code and a sentence; the trial can be opened again afterwards."""
    async with serving.connect("t-1") as ws:
        for number, frame in enumerate(frames):
            await ws.send(frame)
            if number == 0 and len(frames) > 1:
                await read_text(ws, "welcome")
        closed = await read_close(ws)
    assert closed[0] == code
    assert closed[1].startswith(reason)
    async with serving.connect("t-1") as ws:
        await ws.send(HELLO)
        assert (await read_text(ws, "welcome"))["tick"] == 0


async def test_nobody_may_flood_the_server(serving: Serving) -> None:
    """A thousand messages in a burst: the socket is closed and told the limit."""
    async with serving.connect("t-1") as ws:
        await ws.send(HELLO)
        with contextlib.suppress(ConnectionClosed):
            for _ in range(1000):
                await ws.send(json.dumps({"type": "context", "lost": True}))
        assert await read_close(ws) == (4400, "wanted at most 200 messages a second, got more")


async def test_unknown_tokens_and_foreign_pages(serving: Serving) -> None:
    """4401 with a sentence; a page of another origin gets no socket at all."""
    async with serving.connect("nobody") as ws:
        await ws.send(HELLO)
        message = await read_text(ws, "error")
        assert "personal link is not known" in message["message"]
        assert (await read_close(ws))[0] == 4401
    with pytest.raises(InvalidStatus) as caught:
        async with serving.connect("t-1", origin="https://elsewhere.example"):
            pass
    assert caught.value.response.status_code == 403
    assert serving.hall.rooms == {}


async def test_a_second_tab_takes_over_and_a_dropped_line_resumes(serving: Serving) -> None:
    """Older socket 4409; after a drop the same address goes on at the same tick."""
    async with serving.connect("t-1") as older, serving.connect("t-1") as newer:
        await start(older)
        await read_snapshot(older, lambda tick, acknowledged: tick > 0)
        await newer.send(HELLO)
        tick = (await read_text(newer, "welcome"))["tick"]
        assert (await read_close(older))[0] == 4409
        assert tick > 0
        newer.transport.abort()
    async with serving.connect("t-1") as again:
        welcome = await start(again)
        assert welcome["tick"] == tick, "the world stood still meanwhile"


async def test_fuzzed_frames_disturb_nobody(
    serving: Serving, caplog: pytest.LogCaptureFixture
) -> None:
    """2000 random frames: every socket is closed with a code, the neighbour's trial runs on."""
    draws = random.Random(5)
    sent = 0
    async with serving.connect("t-2") as neighbour:
        await start(neighbour)
        room = serving.hall.rooms["t-2"]
        tick = room.world.tick
        while sent < 2000:
            async with serving.connect(f"t-{draws.randint(3, 6)}") as ws:
                with contextlib.suppress(ConnectionClosed):
                    if draws.random() < 0.7:
                        await ws.send(HELLO)
                    if draws.random() < 0.5:
                        await ws.send(READY)
                    for _ in range(40):
                        await ws.send(random_frame(draws))
                        sent += 1
                code, reason = await read_close(ws)
                assert code in (1009, 4400, 4409), (code, reason)
            await neighbour.send(json.dumps({"type": "ping", "sent_ms": 1}))
        await read_text(neighbour, "pong")
        assert room.phase in ("running", "paused")
        assert room.world.tick > tick
        assert neighbour.close_code is None
        neighbour.transport.abort()
    assert "Traceback" not in caplog.text


def random_frame(draws: random.Random) -> str | bytes:
    """Mostly nearly right, sometimes anything."""
    choice = draws.random()
    if choice < 0.3:
        return pack(draws.randint(0, 60), *[(draws.randint(0, 17), draws.randint(0, 65535))])
    if choice < 0.6:
        return draws.randbytes(draws.randint(0, 40))
    if choice < 0.8:
        kind = draws.choice(["ready", "ping", "attention", "context", "hello", "", None, 5])
        value = draws.choice([True, 1, -1.5, None, "x" * draws.randint(0, 300), [1], {}])
        return json.dumps({"type": kind, draws.choice(["sent_ms", "lost", "visible"]): value})
    return "".join(chr(draws.randint(1, 0x2FFF)) for _ in range(draws.randint(0, 80)))


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
