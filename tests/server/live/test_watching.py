"""Guards staff's sockets: who is asked, what may be said, and which audience is left."""

from __future__ import annotations

import asyncio
import json
from types import SimpleNamespace
from typing import Any, cast

from server.live.outbox import SpectatorOutbox
from server.live.watching import SpectatorTalk
from server.live.wire import CloseCode
from server.problems import SignInNeeded

HELLO = json.dumps({"type": "hello", "version": 1})


class Seats:
    """A room as far as its audience goes."""

    def __init__(self) -> None:
        self.sinks: list[Any] = []

    def watch(self, sink: Any) -> None:
        self.sinks.append(sink)

    def leave(self, sink: Any, code: int) -> None:
        del code
        self.sinks.remove(sink)


class Desk(SpectatorOutbox):
    """An outbox that remembers with which code the socket is to end."""

    ended_with: int | None = None

    def close(self, code: int, reason: str) -> None:
        self.ended_with = code
        super().close(code, reason)


async def sent_nowhere(message: Any) -> None:
    del message


def talk_about(rooms: dict[str, Seats], *, signed_in: bool = True) -> SpectatorTalk:
    async def who() -> str:
        if not signed_in:
            raise SignInNeeded
        return "maria"

    hall = cast("Any", SimpleNamespace(rooms=rooms))
    return SpectatorTalk(Desk(sent_nowhere), who, hall, "t")


async def settle() -> None:
    for _ in range(5):
        await asyncio.sleep(0)


async def test_a_spectator_leaves_the_audience_that_it_joined() -> None:
    """Though the trial was meanwhile opened again in another room."""
    first, second = Seats(), Seats()
    rooms = {"t": first}
    talk = talk_about(rooms)
    talk.hear(HELLO)
    await settle()
    assert first.sinks == [talk.outbox]
    rooms["t"] = second
    second.watch("somebody else")
    talk.leave(1000)
    assert first.sinks == []
    assert second.sinks == ["somebody else"]


async def test_nobody_watches_without_signing_in() -> None:
    seats = Seats()
    talk = talk_about({"t": seats}, signed_in=False)
    talk.hear(HELLO)
    await settle()
    assert seats.sinks == []
    assert cast("Desk", talk.outbox).ended_with == CloseCode.WRONG_ORIGIN
    talk.leave(1000)


async def test_a_trial_that_does_not_run_is_said_so() -> None:
    talk = talk_about({})
    talk.hear(HELLO)
    await settle()
    assert cast("Desk", talk.outbox).ended_with == CloseCode.TRY_LATER
    talk.leave(1000)


async def test_spectators_may_only_greet_and_ping() -> None:
    """Whatever else comes ends the socket with what was wanted."""
    for frames in ([b"\x01"], ["no json"], ['{"type":"ready"}'], [HELLO, '{"type":"input"}']):
        talk = talk_about({"t": Seats()})
        for frame in frames:
            talk.hear(cast("Any", frame))
        await settle()
        assert cast("Desk", talk.outbox).ended_with == CloseCode.MALFORMED, frames
        talk.leave(1000)
