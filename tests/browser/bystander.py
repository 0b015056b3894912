"""Participants without a browser: one who stands in a real-time trial, one who does it all."""

from __future__ import annotations

import asyncio
import json
import random
import threading

import httpx2
from websockets.sync.client import connect

from browser.conftest import ADMIN_PASSWORD
from server.live import wire
from server.rehearsal.person import Person, Role, Story
from server.rehearsal.player import Halls
from server.rehearsal.site import Site

FRAMES_A_MESSAGE = 3
LISTEN_S = FRAMES_A_MESSAGE / wire.TICK_HZ


class Bystander:
    """Holds a personal address' trial open and lets no key be pressed, until told to leave."""

    def __init__(self, address: str) -> None:
        self._address = address.replace("http", "ws", 1) + "/live"
        self._is_leaving = threading.Event()
        self._thread = threading.Thread(target=self._stand, daemon=True)
        self._thread.start()

    def leave(self) -> None:
        """Close the socket, as a browser that is closed does."""
        self._is_leaving.set()
        self._thread.join(timeout=30)
        assert not self._thread.is_alive()

    def _stand(self) -> None:
        with connect(self._address, compression=None, proxy=None) as socket:
            socket.send(json.dumps({"type": "hello", "version": wire.PROTOCOL_VERSION}))
            seq, phase = 0, ""
            while not self._is_leaving.is_set():
                try:
                    frame = socket.recv(timeout=LISTEN_S)
                except TimeoutError:
                    frame = b""
                if isinstance(frame, str):
                    message = json.loads(frame)
                    phase = message.get("phase", phase)
                    if message["type"] == "welcome":
                        socket.send(json.dumps({"type": "ready"}))
                elif phase == "running":
                    socket.send(_stand_still(seq + 1))
                    seq += FRAMES_A_MESSAGE


def _stand_still(first_seq: int) -> bytes:
    frames = bytes(3 * FRAMES_A_MESSAGE)
    return wire.INPUT_HEAD.pack(wire.INPUT, first_seq, FRAMES_A_MESSAGE) + frames


def take_part(url: str, study: str) -> str:
    """A simulated participant does the whole study in lock-step; returns the code."""
    with httpx2.Client(base_url=url) as client:
        client.post("/login", data={"name": "admin", "password": ADMIN_PASSWORD})
        issued = client.post(f"/api/v1/studies/{study}/bots", json={"count": 1}).json()["bots"][0]
    story = Story(issued["code"], Role("stays", 1.0, reloads=False, is_late=False))
    person = Person(Site(url), issued["address"], story, random.Random(4), Halls())
    walk = threading.Thread(target=lambda: asyncio.run(person.take_part()))  # beside the browser's
    walk.start()
    walk.join(timeout=120)
    assert (story.end, story.errors) == ("completed", [])
    return story.code
