"""Guards what waits for a socket: order of control messages, one snapshot, nothing without end."""

import asyncio
from typing import Any

from server.live.outbox import MAX_CONTROL, Outbox


class Line:
    """A send callable that can be held up."""

    def __init__(self) -> None:
        self.sent: list[Any] = []
        self.is_open = asyncio.Event()
        self.is_open.set()

    async def send(self, message: Any) -> None:
        await self.is_open.wait()
        self.sent.append(message.get("text") or message.get("bytes") or message.get("code"))


async def settle() -> None:
    for _ in range(20):
        await asyncio.sleep(0)


async def test_newest_snapshot_and_all_control_messages() -> None:
    """While the line is held up: controls queue in order, snapshots replace one another."""
    line = Line()
    outbox = Outbox(line.send, "/p/x")
    writer = asyncio.create_task(outbox.run())
    outbox.send_snapshot(b"0")
    await settle()
    line.is_open.clear()
    for number in range(1, 40):
        outbox.send_snapshot(b"%d" % number)
        if number % 10 == 0:
            outbox.send_control(b"c%d" % number)
            await settle()
    outbox.send_finished()
    line.is_open.set()
    await settle()
    outbox.close(1000, "done")
    await asyncio.wait_for(writer, 1)
    assert line.sent[0] == b"0"
    assert [m for m in line.sent if m in (b"c10", b"c20", b"c30")] == [b"c10", b"c20", b"c30"]
    assert b"39" in line.sent
    assert len(line.sent) <= 8
    assert line.sent[-1] == 1000


async def test_a_client_too_slow_for_control_messages_is_closed() -> None:
    line = Line()
    line.is_open.clear()
    outbox = Outbox(line.send, "/p/x")
    writer = asyncio.create_task(outbox.run())
    for number in range(MAX_CONTROL + 5):
        outbox.send_text(str(number))
    assert outbox.closing.done()
    line.is_open.set()
    await asyncio.wait_for(writer, 1)
    assert line.sent[-1] == 1013
    assert len(line.sent) <= 2


async def test_the_first_close_counts_and_nothing_follows_it() -> None:
    line = Line()
    outbox = Outbox(line.send, "/p/x")
    outbox.send_text("last word")
    outbox.close(4409, "ü" * 100)
    outbox.close(1000, "")
    outbox.send_text("too late")
    await asyncio.wait_for(outbox.run(), 1)
    assert line.sent == ["last word", 4409]


async def test_a_broken_line_ends_quietly() -> None:
    async def broken(message: Any) -> None:
        raise ConnectionResetError

    outbox = Outbox(broken, "/p/x")
    outbox.send_text("hello?")
    await asyncio.wait_for(outbox.run(), 1)
    assert outbox.closing.done()
