"""One trial over the live socket: greets, looks, walks, and hears that it is stored.

In lock-step each message of input is answered by one snapshot, so the trial runs as fast as both
ends can go.
"""

from __future__ import annotations

import asyncio
import json
import random
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import WebSocketException

from server.live import wire
from server.rehearsal.sight import Hall, Sight, read_display, read_snapshot
from server.rehearsal.site import Site, SiteError
from server.rehearsal.walker import Frame, Walker

ANSWER_WITHIN_S = 60.0
OPEN_WITHIN_S = 900.0
LEAST_GAP_S = 1.02 / 200
QUALITY = {"type": "quality", "fps": [60], "rtt_ms": [1], "long_frames": 0, "longest_frame_ms": 17}


@dataclass
class Ended:
    """How a visit to a trial ended; `ticks` the world's last tick seen, `next` the page to open."""

    ticks: int
    next: str


class Player:
    """Plays the trial of one participant. `leave_after` ticks the socket is dropped, if given.

    `began_at`: the tick at which the server went on with the trial; `sight`: what came last.
    """

    def __init__(self, site: Site, path: str, draws: random.Random, halls: Halls) -> None:
        self._url = site.socket_url + path
        self._draws = draws
        self._halls = halls
        self._sent_at_s = 0.0
        self.began_at: int | None = None
        self.sight: Sight | None = None

    async def play(self, leave_after: int | None = None, *, from_tick: int | None = 0) -> Ended:
        """Play to the end, or leave after so many ticks.

        Raises `SiteError` for whatever is not as it should be: a close, silence, another tick
        than the one that was left (with None any tick will do).
        """
        try:
            async with connect(
                self._url, compression=None, proxy=None, open_timeout=ANSWER_WITHIN_S
            ) as socket:
                return await self._play(socket, leave_after, from_tick)
        except (OSError, WebSocketException, TimeoutError) as error:
            raise SiteError(f"the live socket failed ({str(error) or 'nothing came'})") from error

    async def _play(
        self, socket: ClientConnection, leave_after: int | None, from_tick: int | None
    ) -> Ended:
        await _tell(socket, {"type": "hello", "version": wire.PROTOCOL_VERSION})
        welcome = await self._hear_welcome(socket)
        self.began_at = welcome["tick"]
        if from_tick not in (None, self.began_at):
            raise SiteError(f"the trial went on at tick {self.began_at}, not at {from_tick}")
        walker = Walker(self._halls.find(welcome["hall"]), self._draws)
        await _tell(socket, {"type": "attention", "visible": True, "focused": True, "locked": True})
        await _tell(socket, {"type": "ready"})
        await _tell(socket, QUALITY)
        return await self._walk(socket, walker, welcome, leave_after)

    async def _walk(
        self,
        socket: ClientConnection,
        walker: Walker,
        welcome: Mapping[str, Any],
        leave_after: int | None,
    ) -> Ended:
        seq, is_running = welcome["acknowledged_seq"], False
        while True:
            frame = await asyncio.wait_for(socket.recv(), ANSWER_WITHIN_S)
            if isinstance(frame, str):
                message = _read(frame)
                if message["type"] == "finished":
                    last = self.sight.tick if self.sight else welcome["tick"]
                    return Ended(last, message["next"])
                if message["type"] == "phase":
                    is_running = message["phase"] == "running"
                is_turn = is_running and message["type"] == "phase"
            else:
                is_turn = is_running and frame[0] == wire.SNAPSHOT
                if frame[0] == wire.DISPLAY:
                    walker.shown_robots, walker.shown_stations = read_display(frame)
                elif frame[0] == wire.SNAPSHOT:
                    self.sight = read_snapshot(frame)
            if self.sight is None or not is_turn:
                continue
            if leave_after is not None and self.sight.tick >= leave_after:
                return Ended(self.sight.tick, "")
            seq = await self._answer(socket, seq, walker.look(self.sight))

    async def _hear_welcome(self, socket: ClientConnection) -> Mapping[str, Any]:
        while True:
            frame = await asyncio.wait_for(socket.recv(), OPEN_WITHIN_S)
            if isinstance(frame, str):
                message = _read(frame)
                if message["type"] == "welcome":
                    return message

    async def _answer(self, socket: ClientConnection, seq: int, frames: Sequence[Frame]) -> int:
        """Send input frames, not faster than the server lets anybody send."""
        now_s = asyncio.get_running_loop().time()
        wait_s = self._sent_at_s + LEAST_GAP_S - now_s
        if wait_s > 0:
            await asyncio.sleep(wait_s)
        self._sent_at_s = max(now_s, self._sent_at_s + LEAST_GAP_S)
        body = b"".join(struct.pack("<BH", keys, yaw) for keys, yaw in frames)
        await socket.send(wire.INPUT_HEAD.pack(wire.INPUT, seq + 1, len(frames)) + body)
        return seq + len(frames)


class Halls:
    """Halls by their description: the same one for all who walk in it."""

    def __init__(self) -> None:
        self._known: dict[str, Hall] = {}

    def find(self, description: Mapping[str, Any]) -> Hall:
        """The hall of a welcome."""
        hall = {name: value for name, value in description.items() if name != "box_seed"}
        key = json.dumps(hall, sort_keys=True)
        if key not in self._known:
            self._known[key] = Hall(hall)
        return self._known[key]


def _read(text: str) -> dict[str, Any]:
    """A text message; raises `SiteError` if it tells of a fault."""
    message: dict[str, Any] = json.loads(text)
    if message["type"] == "error":
        raise SiteError(f"the live socket said: {message['message']}")
    return message


async def _tell(socket: ClientConnection, message: Mapping[str, Any]) -> None:
    await socket.send(json.dumps(message))
