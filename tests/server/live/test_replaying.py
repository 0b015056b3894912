"""Guards the replay that staff look at: play, pause, speed, seeking, its end, and a damaged one."""

from __future__ import annotations

import asyncio
import itertools
import json
import struct
from collections.abc import AsyncIterator, Callable
from dataclasses import replace
from typing import Any

import pytest

from server.live.opening import open_room
from server.live.outbox import SpectatorOutbox
from server.live.ports import OpenTrial
from server.live.replaying import SPEEDS, ReplayTalk
from server.live.wire import CloseCode
from study.records.journal import JournalChunk
from tests.server.live.stage import SETUP, FakeClock, Stage, serve_stations

PLAYED_S = 10
TURNS = 20_000


class Screen(SpectatorOutbox):
    """The page: what it was sent, and with which code it is left."""

    def __init__(self) -> None:
        super().__init__(_sent_nowhere)
        self.texts: list[dict[str, Any]] = []
        self.snapshots: list[bytes] = []
        self.ended_with: int | None = None

    def send_text(self, text: str) -> None:
        self.texts.append(json.loads(text))

    def send_control(self, data: bytes) -> None:
        del data

    def send_snapshot(self, data: bytes) -> None:
        self.snapshots.append(data)

    def close(self, code: int, reason: str) -> None:
        self.ended_with = self.ended_with or code
        super().close(code, reason)

    @property
    def ticks(self) -> list[int]:
        """The tick of each snapshot."""
        return [int(struct.unpack_from("<I", data, 2)[0]) for data in self.snapshots]

    @property
    def phase(self) -> str:
        """The phase that the page was last told."""
        return next((t["phase"] for t in reversed(self.texts) if t["type"] == "phase"), "")


async def _sent_nowhere(message: Any) -> None:
    del message


@pytest.fixture(scope="module")
def journal() -> tuple[JournalChunk, ...]:
    """A trial's first ten seconds as they would be stored, in several chunks."""
    stage = Stage.open()
    stage.join()
    chunks = []
    for _ in range(PLAYED_S):
        stage.play(1.0, serve_stations)
        batch = stage.room.take_batch()
        assert batch is not None
        assert batch.chunk is not None
        chunks.append(batch.chunk)
    return tuple(chunks)


@pytest.fixture
async def begin(monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Callable[..., ReplayTalk]]:
    """Opens the replay of a journal for a page that has said hello; frames take no time."""
    monkeypatch.setattr("server.live.replaying.FRAME_S", 0.0)
    talks: list[ReplayTalk] = []

    def begun(journal: tuple[JournalChunk, ...]) -> ReplayTalk:
        async def read(trial_id: str) -> OpenTrial:
            assert trial_id == "t-1"
            return OpenTrial(SETUP, journal)

        async def who() -> str:
            return "maria"

        talk = ReplayTalk(Screen(), who, "t-1", read)
        talk.hear('{"type":"hello","version":1}')
        talks.append(talk)
        return talk

    yield begun
    for talk in talks:
        talk.leave(1000)
    await asyncio.sleep(0)


def screen_of(talk: ReplayTalk) -> Screen:
    assert isinstance(talk.outbox, Screen)
    return talk.outbox


def say(talk: ReplayTalk, **message: Any) -> None:
    talk.hear(json.dumps(message))


async def until(is_so: Callable[[], bool]) -> None:
    """Let the replay go on until something is so."""
    for _ in range(TURNS):
        if is_so():
            return
        await asyncio.sleep(0)
    raise AssertionError("it never came to that")


async def rest(talk: ReplayTalk) -> Screen:
    """Wait until it stands still; the messages until then are forgotten."""
    screen = screen_of(talk)
    await until(lambda: screen.phase in ("paused", "finished"))
    screen.texts.clear()
    screen.snapshots.clear()
    return screen


async def test_it_opens_paused_at_its_beginning_with_its_length(
    begin: Callable[..., ReplayTalk], journal: tuple[JournalChunk, ...]
) -> None:
    screen = screen_of(begin(journal))
    await until(lambda: screen.phase == "paused")
    assert [t["ticks"] for t in screen.texts if t["type"] == "length"] == [journal[-1].last_tick]
    assert screen.ticks[-1] == 0


@pytest.mark.parametrize("speed", SPEEDS)
async def test_each_speed_shows_so_many_ticks_a_frame(
    begin: Callable[..., ReplayTalk], journal: tuple[JournalChunk, ...], speed: float
) -> None:
    """Fifteen frames a second, so twice the speed in ticks for each; the last is the trial's."""
    talk = begin(journal)
    screen = await rest(talk)
    say(talk, type="speed", times=speed)
    say(talk, type="play")
    await until(lambda: screen.phase == "finished")
    ticks = [0, *screen.ticks]
    steps = [b - a for a, b in itertools.pairwise(ticks)]
    if speed >= 0.5:
        assert set(steps[:15]) == {round(2 * speed)}
    else:
        assert steps[:20] == [0, 1] * 10
    assert ticks[-1] == journal[-1].last_tick


async def test_seeking_forwards_and_backwards_shows_what_was_at_that_moment(
    begin: Callable[..., ReplayTalk], journal: tuple[JournalChunk, ...]
) -> None:
    """The same picture as by playing up to there, and as in the room at the time."""
    clock = FakeClock()
    room = (await open_room(OpenTrial(SETUP, journal[:5]), clock)).world
    talk = begin(journal)
    screen = await rest(talk)
    pictures = {}
    for tick in (room.tick, 270, 40, room.tick):
        say(talk, type="seek", tick=tick)
        await until(lambda wanted=tick: screen.ticks[-1:] == [wanted] and screen.phase == "paused")
        welcome = [t for t in screen.texts if t["type"] == "welcome"][-1]
        assert welcome["tick"] == tick
        assert pictures.setdefault(tick, screen.snapshots[-1]) == screen.snapshots[-1]
        if tick == room.tick:
            place = (welcome["human"]["x_m"], welcome["human"]["y_m"])
            assert place == (float(room.human_x_m), float(room.human_y_m))
        await rest(talk)
    assert len(set(pictures.values())) == 3


async def test_who_has_sought_often_is_sent_each_picture_once(
    begin: Callable[..., ReplayTalk], journal: tuple[JournalChunk, ...]
) -> None:
    """A page that looks at the same film again does not sit in its audience twice."""
    talk = begin(journal)
    screen = await rest(talk)
    for tick in (30, 60, 90):
        say(talk, type="seek", tick=tick)
        await rest(talk)
    say(talk, type="play")
    await until(lambda: len(screen.ticks) > 10)
    assert screen.ticks[2:] == sorted(set(screen.ticks[2:]))


async def test_the_latest_of_several_wishes_counts(
    begin: Callable[..., ReplayTalk], journal: tuple[JournalChunk, ...]
) -> None:
    """Also while an earlier one is still being simulated; beyond the end is the end."""
    talk = begin(journal)
    screen = await rest(talk)
    say(talk, type="seek", tick=290)
    await asyncio.sleep(0)
    say(talk, type="seek", tick=61)
    await until(lambda: screen.ticks[-1:] == [61] and screen.phase == "paused")
    say(talk, type="seek", tick=10**8)
    await until(lambda: screen.phase == "finished")
    assert screen.ticks[-1] == journal[-1].last_tick


async def test_pausing_holds_and_playing_after_the_end_begins_anew(
    begin: Callable[..., ReplayTalk], journal: tuple[JournalChunk, ...]
) -> None:
    talk = begin(journal)
    screen = await rest(talk)
    say(talk, type="play")
    await until(lambda: len(screen.ticks) > 3)
    say(talk, type="pause")
    await until(lambda: screen.phase == "paused")
    held = screen.ticks[-1]
    say(talk, type="speed", times=8)
    for _ in range(50):
        await asyncio.sleep(0)
    assert screen.ticks[-1] == held, "a new speed does not set it going"
    assert [t["phase"] for t in screen.texts if t["type"] == "phase"][-1] == "paused"
    say(talk, type="play")
    await until(lambda: screen.phase == "finished")
    say(talk, type="play")
    await until(lambda: 0 < screen.ticks[-1] < journal[-1].last_tick)


async def test_a_state_that_is_not_reached_again_ends_it_with_the_tick(
    begin: Callable[..., ReplayTalk], journal: tuple[JournalChunk, ...]
) -> None:
    """A picture that never was is not shown."""
    chunk = journal[3]
    tick, digest = chunk.hashes[-1]
    spoilt = replace(chunk, hashes=((tick, bytes(reversed(digest))),))
    talk = begin((*journal[:3], spoilt, *journal[4:]))
    screen = await rest(talk)
    say(talk, type="play")
    await until(lambda: screen.ended_with is not None)
    assert screen.ended_with == CloseCode.CANNOT_RESUME
    (error,) = [t["message"] for t in screen.texts if t["type"] == "error"]
    assert f"tick {tick}" in error
    assert max(screen.ticks) < tick


async def test_a_trial_without_a_journal_says_so(begin: Callable[..., ReplayTalk]) -> None:
    screen = screen_of(begin(()))
    await until(lambda: screen.ended_with == CloseCode.NO_TRIAL)
    assert "nothing was played" in screen.texts[-1]["message"]


@pytest.mark.parametrize(
    "message",
    [
        {"type": "speed", "times": 3},
        {"type": "speed", "times": "fast"},
        {"type": "seek", "tick": "12"},
        {"type": "seek", "tick": 1.5},
        {"type": "input"},
    ],
)
async def test_what_makes_no_sense_ends_the_socket(
    begin: Callable[..., ReplayTalk],
    journal: tuple[JournalChunk, ...],
    message: dict[str, Any],
) -> None:
    talk = begin(journal)
    await rest(talk)
    talk.hear(json.dumps(message))
    assert screen_of(talk).ended_with == CloseCode.MALFORMED
