"""What waits to be sent over one socket: every control message, and only the newest snapshot."""

from __future__ import annotations

import asyncio
import contextlib
import socket
from collections import deque
from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any

from server.live.wire import CloseCode, crop_reason, encode_finished

AsgiMessage = MutableMapping[str, Any]
Send = Callable[[AsgiMessage], Awaitable[None]]

MAX_CONTROL = 256
KERNEL_BUFFER_BYTES = 16384
UNSENT_BYTES = 2048


class Outbox:
    """A Sink over one WebSocket. `run` is the socket's only writer.

    A client that reads too slowly for its control messages is closed: nothing grows without end.
    `closing` is resolved as soon as the socket is to end.
    """

    def __init__(self, send: Send, next_path: str) -> None:
        self.closing: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._send = send
        self._next_path = next_path
        self._control: deque[AsgiMessage] = deque()
        self._snapshot: bytes | None = None
        self._wake = asyncio.Event()
        self._close: AsgiMessage | None = None

    def send_text(self, text: str) -> None:
        """Queue a text message."""
        self._queue({"type": "websocket.send", "text": text})

    def send_control(self, data: bytes) -> None:
        """Queue a binary message that must arrive."""
        self._queue({"type": "websocket.send", "bytes": data})

    def send_snapshot(self, data: bytes) -> None:
        """Put the newest snapshot in the place of the last, if that is still here."""
        self._snapshot = data
        self._wake.set()

    def send_finished(self) -> None:
        """Tell where the participant goes next."""
        self.send_text(encode_finished(self._next_path))

    def close(self, code: int, reason: str) -> None:
        """End the socket once what is queued has gone; the first call counts."""
        if self._close is None:
            self._close = {
                "type": "websocket.close",
                "code": int(code),
                "reason": crop_reason(reason),
            }
            self._snapshot = None
            self._wake.set()
            if not self.closing.done():
                self.closing.set_result(None)

    async def run(self) -> None:
        """Send until closed. A broken line ends it quietly."""
        with contextlib.suppress(OSError, RuntimeError):
            await self._send_until_closed()
        if not self.closing.done():
            self.closing.set_result(None)

    async def _send_until_closed(self) -> None:
        while True:
            await self._wake.wait()
            self._wake.clear()
            while self._control:
                await self._send(self._control.popleft())
            if self._snapshot is not None:
                data, self._snapshot = self._snapshot, None
                await self._send({"type": "websocket.send", "bytes": data})
            elif self._close is not None and not self._control:
                await self._send(self._close)
                return

    def _queue(self, message: AsgiMessage) -> None:
        if self._close is not None:
            return
        if len(self._control) >= MAX_CONTROL:
            self._control.clear()
            self.close(CloseCode.TRY_LATER, "this connection is too slow")
            return
        self._control.append(message)
        self._wake.set()


def keep_buffers_small(send: Send) -> None:
    """Ask the socket below an ASGI server to hold little, so that a slow client sees no backlog.

    ASGI does not show the socket; uvicorn's `send` is a method of the object that has it. With
    another server, or behind a wrapper, nothing is changed.
    """
    transport: Any = getattr(getattr(send, "__self__", None), "transport", None)
    with contextlib.suppress(OSError, AttributeError):
        transport.set_write_buffer_limits(high=UNSENT_BYTES)
        raw = transport.get_extra_info("socket")
        raw.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, KERNEL_BUFFER_BYTES)
        raw.setsockopt(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT, UNSENT_BYTES)
