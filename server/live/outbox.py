"""What waits to be sent over one socket: every control message, and only the newest snapshot."""

from __future__ import annotations

import asyncio
import contextlib
from collections import deque
from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any

from server.live.line import Line
from server.live.wire import CloseCode, crop_reason, encode_finished

AsgiMessage = MutableMapping[str, Any]
Send = Callable[[AsgiMessage], Awaitable[None]]

MAX_CONTROL = 256


class Outbox:
    """A Sink over one WebSocket. What cannot go down its `line` at once is sent by `run`.

    A client that reads too slowly for its control messages is closed: nothing grows without end.
    `closing` is resolved as soon as the socket is to end.
    """

    def __init__(self, send: Send, next_path: str, line: Line | None = None) -> None:
        self.closing: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._send = send
        self._line = line
        self._is_sending = False
        self._next_path = next_path
        self._control: deque[str | bytes] = deque()
        self._snapshot: bytes | None = None
        self._wake = asyncio.Event()
        self._close: AsgiMessage | None = None

    def send_text(self, text: str) -> None:
        """Queue a text message."""
        self._queue(text)

    def send_control(self, data: bytes) -> None:
        """Queue a binary message that must arrive."""
        self._queue(data)

    def send_snapshot(self, data: bytes) -> None:
        """Put the newest snapshot in the place of the last, if that is still here."""
        line = self._clear_line()
        if line is not None:
            self._snapshot = None
            line.write(data)
        else:
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
            self._is_sending = True
            while self._control:
                await self._send(_as_message(self._control.popleft()))
            if self._snapshot is not None:
                data, self._snapshot = self._snapshot, None
                await self._send(_as_message(data))
            elif self._close is not None and not self._control:
                await self._send(self._close)
                return
            self._is_sending = False

    def _queue(self, frame: str | bytes) -> None:
        if self._close is not None:
            return
        line = self._clear_line()
        if line is not None:
            line.write(frame)
        elif len(self._control) >= MAX_CONTROL:
            self._control.clear()
            self.close(CloseCode.TRY_LATER, "this connection is too slow")
        else:
            self._control.append(frame)
            self._wake.set()

    def _clear_line(self) -> Line | None:
        """The line, if what is written to it overtakes nothing and waits for nobody."""
        line = self._line
        if line is None or self._is_sending or self._control or self._close is not None:
            return None
        return line if line.is_free else None


class SpectatorOutbox(Outbox):
    """The outbox of somebody who only watches: where a participant goes next is not for them."""

    def __init__(self, send: Send, line: Line | None = None) -> None:
        super().__init__(send, "", line)

    def send_finished(self) -> None:
        """Watchers stay where they are; the phase has told them that the trial is over."""


def _as_message(frame: str | bytes) -> AsgiMessage:
    kind = "text" if isinstance(frame, str) else "bytes"
    return {"type": "websocket.send", kind: frame}
