"""Guards staff's sockets: who is asked, what may be said, and which audience is left."""

from __future__ import annotations

import asyncio
import json
from types import SimpleNamespace
from typing import Any, cast

import pytest

from server.live.opening import open_room
from server.live.outbox import SpectatorOutbox
from server.live.ports import OpenTrial
from server.live.watching import SpectatorTalk
from server.live.wire import CloseCode
from server.problems import SignInNeeded
from server.store.engine import StorageAway
from tests.server.live.stage import SETUP, FakeClock, Stage, serve_stations

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


def talk_about(
    rooms: dict[str, Seats], *, signed_in: bool = True, over: bool = False
) -> SpectatorTalk:
    async def who() -> str:
        if not signed_in:
            raise SignInNeeded
        return "maria"

    async def is_over(trial_id: str) -> bool:
        assert trial_id == "t"
        return over

    hall = cast("Any", SimpleNamespace(rooms=rooms))
    return SpectatorTalk(Desk(sent_nowhere), who, hall, "t", is_over)


async def open_stage() -> Stage:
    clock = FakeClock()
    return Stage(await open_room(OpenTrial(SETUP), clock), clock)


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


async def test_a_trial_that_has_ended_is_not_waited_for() -> None:
    """The page is told for good, so that it leads to the replay instead of trying again."""
    talk = talk_about({}, over=True)
    talk.hear(HELLO)
    await settle()
    assert cast("Desk", talk.outbox).ended_with == CloseCode.NO_TRIAL
    talk.leave(1000)


async def test_who_watches_to_the_end_hears_that_it_is_over_and_is_sent_nowhere() -> None:
    """The participant's page is told where to go next; a spectator's hears the phase alone."""
    stage = await open_stage()
    participant = stage.join()
    desk = Desk(sent_nowhere)
    heard: list[Any] = []
    desk.send_text = heard.append  # type: ignore[method-assign]
    stage.room.watch(desk)
    stage.play_to_end(serve_stations)
    stage.room.finish_stored()
    phases = [json.loads(text)["phase"] for text in heard if '"phase"' in text]
    assert phases[-1] == "finished"
    assert not any('"finished","next"' in text for text in heard)
    assert participant.is_finished
    assert desk.ended_with is None


async def test_spectators_come_and_go_unnoticed_by_the_trial() -> None:
    """Neither the journal, nor the clock, nor who takes part changes by somebody looking on."""
    stage = await open_stage()
    stage.join()
    stage.room.take_batch()
    desk = Desk(sent_nowhere)
    stage.room.watch(desk)
    stage.room.leave(desk, 1001)
    assert stage.room.take_batch() is None
    assert stage.room.is_joined
    assert stage.room.presence.absent_s() == 0.0


async def test_an_account_that_is_changed_sees_no_more(monkeypatch: pytest.MonkeyPatch) -> None:
    """Though the page stays open; a storage that does not answer for a while closes nothing."""
    monkeypatch.setattr("server.live.watching.IDENTIFY_EVERY_S", 0.001)
    seats, answers = Seats(), [True, True, StorageAway(), True, SignInNeeded()]
    asked = 0

    async def who() -> str:
        nonlocal asked
        answer = answers[min(asked, len(answers) - 1)]
        asked += 1
        if isinstance(answer, Exception):
            raise answer
        return "maria"

    talk = talk_about({"t": seats})
    talk.identify = who
    talk.hear(HELLO)
    await asyncio.wait_for(asyncio.shield(talk.outbox.closing), 5)
    assert asked == len(answers)
    assert cast("Desk", talk.outbox).ended_with == CloseCode.WRONG_ORIGIN
    talk.leave(1000)
    assert seats.sinks == []


async def test_spectators_may_only_greet_and_ping() -> None:
    """Whatever else comes ends the socket with what was wanted."""
    for frames in ([b"\x01"], ["no json"], ['{"type":"ready"}'], [HELLO, '{"type":"input"}']):
        talk = talk_about({"t": Seats()})
        for frame in frames:
            talk.hear(cast("Any", frame))
        await settle()
        assert cast("Desk", talk.outbox).ended_with == CloseCode.MALFORMED, frames
        talk.leave(1000)
