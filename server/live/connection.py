"""One WebSocket from handshake to close, whoever is at its other end.

Participants, workers, experts and spectators differ in what they may say; how a socket is
accepted, read, written and ended is the same and stands here.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable, Mapping, MutableMapping
from typing import Any, Protocol

from starlette.datastructures import Headers

from server.live.line import Line, find_line
from server.live.outbox import Outbox, Send
from server.live.wire import CloseCode, WireError

Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
CLOSE_WITHIN_S = 5.0
NO_STATUS = 1005


class Talk(Protocol):
    """What one end says and hears."""

    def hear(self, frame: str | bytes) -> None:
        """Take one message; what does not fit ends the socket."""
        ...

    def leave(self, code: int) -> None:
        """The socket ends with this close code."""
        ...


async def serve_socket(
    scope: Mapping[str, Any],
    receive: Receive,
    send: Send,
    same_origin: Callable[[Headers], bool],
    begin: Callable[[Line | None], tuple[Outbox, Talk]],
) -> None:
    """Accept a socket of our own pages and serve it to its end; `begin` makes both its sides.

    One that a foreign page opens is turned away before it is accepted.
    """
    await receive()
    if not same_origin(Headers(raw=list(scope["headers"]))):
        await send({"type": "websocket.close", "code": CloseCode.WRONG_ORIGIN})
        return
    await send({"type": "websocket.accept"})
    line = find_line(scope)
    outbox, talk = begin(line)
    if line is not None:
        line.listen(talk.hear)
    writer = asyncio.create_task(outbox.run())
    reader = asyncio.create_task(_read(talk, receive))
    ends: set[asyncio.Future[Any]] = {reader, outbox.closing}
    code = NO_STATUS
    try:
        await asyncio.wait(ends, return_when=asyncio.FIRST_COMPLETED)
        if reader.done() and not reader.cancelled() and reader.exception() is None:
            code = reader.result()
    finally:
        talk.leave(code)
        reader.cancel()
        if outbox.closing.done():
            await asyncio.wait({writer}, timeout=CLOSE_WITHIN_S)
        writer.cancel()
        await asyncio.gather(reader, writer, return_exceptions=True)


async def _read(talk: Talk, receive: Receive) -> int:
    """Read until the socket ends; what its line hears directly does not come by here."""
    while True:
        message = await receive()
        if message["type"] == "websocket.disconnect":
            return message.get("code") or NO_STATUS
        data = message.get("bytes")
        talk.hear(message["text"] if data is None else data)


class Allowance:
    """How many messages an end may send: so many a second, and some more at a time."""

    def __init__(self, per_s: float, burst: float) -> None:
        self._per_s = per_s
        self._burst = burst
        self._left = burst
        self._at_s = 0.0

    def spend(self) -> None:
        """Count a message. Raises WireError when there were too many."""
        now_s = time.perf_counter()
        self._left = min(self._burst, self._left + (now_s - self._at_s) * self._per_s) - 1.0
        self._at_s = now_s
        if self._left < 0.0:
            raise WireError(f"at most {self._per_s:.0f} messages a second", "more")
