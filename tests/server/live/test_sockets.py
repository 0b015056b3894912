"""Guards the endpoint over real sockets: handshake, states, codes, hostile clients."""

import contextlib
import json
import random

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus

from .line import HELLO, READY, Serving, pack, read_close, read_snapshot, read_text, start


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
