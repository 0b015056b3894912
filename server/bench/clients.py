"""The load of `varil bench live`: participants' sockets in a process of their own.

Deliberately no WebSocket library: the clients must cost as little as possible, so that what is
measured is the server. Each client says hello, is ready when it was welcomed, and then sends one
input frame every 1/30 s, taken from a recorded walk. Bytes are counted as they come off the wire.
"""

from __future__ import annotations

import asyncio
import base64
import struct
import time
from collections.abc import Sequence
from multiprocessing.connection import Connection
from typing import cast

MASK = bytes(4)
PERIOD_S = 1 / 30
GROUPS = 15


class BenchClient(asyncio.Protocol):
    """One participant's browser, as far as the line is concerned."""

    def __init__(self, path: str, walk: Sequence[tuple[int, int]]) -> None:
        self.received_bytes = 0
        self.is_running = False
        self._walk = walk
        self._path = path
        self._seq = 0
        self._state = "handshake"
        self._transport: asyncio.Transport | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Ask for the upgrade."""
        self._transport = cast(asyncio.Transport, transport)
        key = base64.b64encode(bytes(16)).decode()
        head = (
            f"GET {self._path} HTTP/1.1\r\nHost: bench\r\nUpgrade: websocket\r\n"
            f"Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {key}\r\n\r\n"
        )
        self._transport.write(head.encode())

    def data_received(self, data: bytes) -> None:
        """Count, and go on to the next state when its sign is seen."""
        self.received_bytes += len(data)
        if self._state == "handshake" and b"\r\n\r\n" in data:
            self._state = "welcome"
            self._send(1, b'{"type":"hello","version":1}')
        elif self._state == "welcome" and b'"welcome"' in data:
            self._state = "ready"
            self._send(1, b'{"type":"ready"}')
        elif self._state == "ready" and b'"running"' in data:
            self._state, self.is_running = "running", True

    def send_frame(self) -> None:
        """One input frame of the recorded walk."""
        if self.is_running:
            keys, yaw = self._walk[self._seq % len(self._walk)]
            self._seq += 1
            self._send(2, struct.pack("<BIBBH", 1, self._seq, 1, keys, yaw))

    def _send(self, opcode: int, payload: bytes) -> None:
        if self._transport is not None and not self._transport.is_closing():
            head = bytes((0x80 | opcode, 0x80 | len(payload)))
            self._transport.write(head + MASK + payload)


async def play(
    port: int,
    walk: Sequence[tuple[int, int]],
    control: Connection,
    kind: type[BenchClient] = BenchClient,
) -> None:
    """Add clients and report bytes as the other side asks for, until it says stop."""
    clients: list[BenchClient] = []
    sending = asyncio.create_task(_send_forever(clients))
    loop = asyncio.get_running_loop()
    while True:
        word, value = await asyncio.to_thread(control.recv)
        if word == "add":
            for path in value:
                client = kind(path, walk)
                await loop.create_connection(lambda c=client: c, "127.0.0.1", port)  # type: ignore[misc]
                clients.append(client)
                await asyncio.sleep(0.002)
            control.send(len(clients))
        elif word == "count":
            running = sum(client.is_running for client in clients)
            control.send((running, sum(c.received_bytes for c in clients), time.perf_counter()))
        else:
            break
    sending.cancel()


async def _send_forever(clients: list[BenchClient]) -> None:
    """Frames of all clients, spread over the period in fifteen parts."""
    next_s, part = time.perf_counter(), 0
    while True:
        next_s += PERIOD_S / GROUPS
        await asyncio.sleep(max(0.0, next_s - time.perf_counter()))
        for client in clients[part::GROUPS]:
            client.send_frame()
        part = (part + 1) % GROUPS


def run_clients(
    port: int,
    walk: Sequence[tuple[int, int]],
    control: Connection,
    core: int | None,
    kind: type[BenchClient] = BenchClient,
) -> None:
    """Entry of the clients' process, held to one core where the system allows it."""
    import os

    import uvloop

    if core is not None:
        os.sched_setaffinity(0, {core})
    uvloop.run(play(port, walk, control, kind))
