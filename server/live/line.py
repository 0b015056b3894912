"""A WebSocket without detours, for uvicorn: frames are heard within the read event that brought
them, and what is sent goes to the transport at once.

By way of ASGI each frame takes a message, a queue, a change of tasks and, when received, two
changes of the poller. With hundreds of participants who send 30 frames a second that costs more
than their worlds. So the protocol puts itself into the scope; an endpoint that finds it there
talks to it directly, and one that does not (another server, a test) is served by ASGI messages.
"""

from __future__ import annotations

import contextlib
import socket
from collections.abc import Callable, Mapping
from typing import Any, Protocol, cast

from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.frames import Frame, Opcode
from websockets.http11 import Request

try:
    from websockets.speedups import apply_mask
except ImportError:
    from websockets.utils import apply_mask

EXTENSION = "varil.line"
KERNEL_BUFFER_BYTES = 16384
UNSENT_BYTES = 2048
SHORT = 126
MASKED = 128
FRAME_HEAD = 6  # two bytes and the mask, for a short frame of a client
BINARY_FRAME = 0x82
WHOLE_FRAMES = (BINARY_FRAME, 0x81, 0x88, 0x89, 0x8A)  # text, close, ping, pong
_HEADS = {
    opcode: tuple(bytes((0x80 | opcode, length)) for length in range(SHORT))
    for opcode in (Opcode.TEXT, Opcode.BINARY)
}


class Line(Protocol):
    """A socket that can be used directly. Nothing here waits."""

    @property
    def is_free(self) -> bool:
        """Whether the client keeps up: what is written now leaves soon."""
        ...

    def write(self, frame: str | bytes) -> None:
        """Send a message; one on a socket that is closing is dropped."""
        ...

    def listen(self, hear: Callable[[str | bytes], None]) -> None:
        """Hand every further message to `hear`, in order; the socket's end is still received."""
        ...


def find_line(scope: Mapping[str, Any]) -> Line | None:
    """The line below an ASGI socket, if its server offers one."""
    return cast("Line | None", scope.get("extensions", {}).get(EXTENSION))


class LineProtocol(WebSocketsSansIOProtocol):
    """uvicorn's WebSocket that also is a `Line`. For `uvicorn.Config(ws=LineProtocol)`."""

    _hear: Callable[[str | bytes], None] | None = None
    _rest: bytes | None = None  # of a frame that is not complete; None: the library reads alone

    @property
    def is_free(self) -> bool:
        """Whether less than the limit waits in the transport."""
        return self.writable.is_set()

    def write(self, frame: str | bytes) -> None:
        """Frame and send; the library frames what is long."""
        if self.close_sent or self.disconnected or self.transport.is_closing():
            return
        opcode = Opcode.TEXT if isinstance(frame, str) else Opcode.BINARY
        data = frame.encode() if isinstance(frame, str) else frame
        if len(data) < SHORT:
            self.transport.write(_HEADS[opcode][len(data)] + data)
        else:
            self.transport.write(Frame(opcode, data).serialize(mask=False))

    def listen(self, hear: Callable[[str | bytes], None]) -> None:
        """Hear directly from now on, and hold little back, so that a slow client has no backlog."""
        self._hear = hear
        self.transport.set_write_buffer_limits(high=UNSENT_BYTES)
        raw = self.transport.get_extra_info("socket")
        with contextlib.suppress(OSError, AttributeError):
            raw.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, KERNEL_BUFFER_BYTES)
            raw.setsockopt(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT, UNSENT_BYTES)

    def handle_connect(self, event: Request) -> None:
        """Offer the line to the application."""
        super().handle_connect(event)
        if not self.close_sent:
            self._rest = None if self.conn.reader.buffer else b""
            cast("dict[str, Any]", self.scope["extensions"])[EXTENSION] = self

    def data_received(self, data: bytes) -> None:
        """Hear short binary frames at once; the library reads all others.

        It is given whole frames, so it always stands between two of them. After the first frame
        that is neither short nor whole it reads alone: then it knows best what fits.
        """
        if self._rest is None:
            super().data_received(data)
            return
        data, at = self._rest + data, 0
        while len(data) - at >= FRAME_HEAD:
            first, end = data[at], at + FRAME_HEAD + (data[at + 1] & 127)
            if first not in WHOLE_FRAMES or not MASKED <= data[at + 1] < MASKED + SHORT:
                self._rest = None
                super().data_received(data[at:])
                return
            if end > len(data):
                break
            if first == BINARY_FRAME and self._hear is not None and self._hears_now:
                mask_at = at + 2
                self._hear(apply_mask(data[at + FRAME_HEAD : end], data[mask_at : mask_at + 4]))
            else:
                super().data_received(data[at:end])
            at = end
        self._rest = data[at:]

    @property
    def _hears_now(self) -> bool:
        """Whether no earlier message waits and neither side has closed."""
        return self.queue.empty() and not self.close_sent and self.conn.close_rcvd is None

    def send_receive_event_to_app(self) -> None:
        """A message is complete: it is heard at once, unless earlier ones still wait."""
        if self._hear is None or not self._hears_now:
            super().send_receive_event_to_app()
            return
        data = b"".join(self.frames)
        if self.curr_msg_data_type == "bytes":
            self.frames = []
            self._hear(data)
            return
        try:
            text = data.decode()
        except UnicodeDecodeError:
            super().send_receive_event_to_app()
        else:
            self.frames = []
            self._hear(text)
