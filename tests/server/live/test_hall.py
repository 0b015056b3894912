"""Guards the hall and the writer: one room per trial, nothing lost, completion after commit."""

import asyncio
from dataclasses import replace

import pytest

from server.live import wire
from server.live.hall import Hall, StillStoring
from study.errors import UnknownToken

from .stage import PERIOD_S, SETUP, FakeClock, Listener, MemoryDesk, Stage, serve_stations, stand

TOKEN = "token-t-1"


async def be_ready() -> None:
    """The kernels are there already."""


def make(*others: str) -> tuple[FakeClock, MemoryDesk, Hall]:
    clock = FakeClock()
    setups = [SETUP, *(replace(SETUP, trial_id=name) for name in others)]
    desk = MemoryDesk(*setups)
    return clock, desk, Hall(desk, be_ready, clock)


async def enter(hall: Hall, clock: FakeClock, token: str = TOKEN) -> Stage:
    return Stage(await hall.enter(token), clock)


async def test_two_sockets_at_once_open_one_room() -> None:
    """However many ask at the same moment, a trial has one world."""
    _, _, hall = make()
    rooms = await asyncio.gather(*(hall.enter(TOKEN) for _ in range(5)))
    assert len({id(room) for room in rooms}) == 1
    assert len(hall.rooms) == len(list(hall.ticker)) == 1


async def test_an_unknown_token_opens_nothing() -> None:
    _, _, hall = make()
    with pytest.raises(UnknownToken):
        await hall.enter("guess")
    assert hall.rooms == {}


async def test_sockets_wait_until_the_world_is_compiled() -> None:
    """Entering before that is no error; it opens when the kernels are there."""
    clock, desk, _ = make()
    gate = asyncio.Event()

    async def compile_slowly() -> None:
        await gate.wait()

    hall = Hall(desk, compile_slowly, clock)
    await hall.start()
    entering = asyncio.create_task(hall.enter(TOKEN))
    await asyncio.sleep(0.05)
    assert not entering.done()
    assert not hall.is_ready
    gate.set()
    await asyncio.wait_for(entering, 5)
    assert hall.is_ready
    await hall.stop()


async def test_a_finished_trial_is_told_only_after_its_commit() -> None:
    """The database fails three times: the client hears nothing, then all is there."""
    clock, desk, hall = make()
    stage = await enter(hall, clock)
    listener = stage.join()
    stage.play_to_end(serve_stations)
    desk.failures = 3
    for _ in range(3):
        assert not await hall.writer.flush()
        assert not listener.is_finished
        assert hall.writer.failing_since_s is not None
        assert desk.results == {}
    assert await hall.writer.flush()
    assert listener.is_finished
    assert desk.results["t-1"].status == "completed"
    assert hall.writer.failing_since_s is None
    assert hall.rooms == {}
    assert list(hall.ticker) == []


async def test_nothing_is_lost_or_doubled_while_the_database_is_away() -> None:
    """Play goes on; later the chunks join without gap and the events are numbered through."""
    clock, desk, hall = make("t-2")
    stages = [await enter(hall, clock, f"token-{name}") for name in ("t-1", "t-2")]
    for stage in stages:
        stage.join()
    for failing in (0, 4, 0, 2, 0, 0):
        desk.failures = failing
        for _ in range(3):
            for stage in stages:
                stage.play(0.5, stand)
            await hall.writer.flush()
    while not await hall.writer.flush():
        pass
    for stage, name in zip(stages, ("t-1", "t-2"), strict=True):
        chunks = desk.chunks[name]
        assert [c.first_tick for c in chunks[1:]] == [c.last_tick + 1 for c in chunks[:-1]]
        assert chunks[-1].last_tick == stage.room.world.tick
        assert [e.number for e in desk.events[name]] == list(range(len(desk.events[name])))


async def test_a_stopped_server_resumes_where_it_was() -> None:
    """Stop the hall, make another on the same desk: the same state, paused, then finished."""
    clock, desk, hall = make()
    await hall.start()
    stage = await enter(hall, clock)
    listener = stage.join()
    stage.play(12.0, serve_stations)
    before = stage.room.world.state_hash()
    await hall.stop()
    assert listener.closed is not None
    assert listener.closed[0] == 1012
    assert desk.kinds()[-1] == "paused"
    again = Hall(desk, be_ready, clock)
    resumed = await enter(again, clock)
    assert (resumed.room.phase, resumed.room.world.state_hash()) == ("paused", before)
    resumed.seq = desk.chunks["t-1"][-1].last_seq
    resumed.join()
    resumed.play_to_end(serve_stations)
    assert await again.writer.flush()
    assert desk.results["t-1"].status == "completed"


async def test_a_trial_that_ends_while_it_is_asked_for_is_asked_for_again() -> None:
    """The desk's answer was read before the end: it must not open the finished trial anew."""
    clock, desk, hall = make()
    stage = await enter(hall, clock)
    stage.join()
    stage.play_to_end(serve_stations)
    entering = asyncio.create_task(hall.enter(TOKEN))
    await asyncio.sleep(0)
    del desk.setups[TOKEN]
    await hall.writer.flush()
    with pytest.raises(UnknownToken):
        await entering
    assert hall.rooms == {}


async def test_a_fault_in_one_trial_keeps_its_journal_and_the_others(
    caplog: pytest.LogCaptureFixture,
) -> None:
    """The faulty room's client is told to try again; what it had played is stored."""
    clock, desk, hall = make("t-2")
    sick, sound = [await enter(hall, clock, f"token-{name}") for name in ("t-1", "t-2")]
    listeners = [sick.join(), sound.join()]
    sick.play(2.0, stand)
    played = sick.room.world.tick

    def break_down(frames: object) -> None:
        raise ZeroDivisionError("a fault")

    sick.room.world.step = break_down  # type: ignore[method-assign, assignment]
    for _ in range(8):
        clock.pass_s(PERIOD_S / 4)
        hall.ticker.run_slot()
    assert listeners[0].closed == (1013, "this trial had a fault and was paused; try again")
    assert listeners[1].closed is None
    assert "ZeroDivisionError" in caplog.text
    await hall.writer.flush()
    assert desk.chunks["t-1"][-1].last_tick == played
    again = await enter(hall, clock)
    assert again.room.world.tick == played
    assert list(hall.rooms) == ["t-2", "t-1"]


async def test_a_damaged_journal_does_not_open() -> None:
    """Stored inputs that do not give the recorded states are an error, not another trial."""
    from study.errors import JournalError

    clock, desk, hall = make()
    stage = await enter(hall, clock)
    stage.join()
    stage.play(3.0, stand)
    await hall.stop()
    chunk = desk.chunks["t-1"][0]
    desk.chunks["t-1"][0] = replace(chunk, hashes=((30, b"otherwise"),))
    again = Hall(desk, be_ready, clock)
    with pytest.raises(JournalError, match=r"tick 30: the replayed state differs"):
        await again.enter(TOKEN)
    assert again.rooms == {}


async def test_a_trial_whose_participant_withdrew_is_closed() -> None:
    """The next commit says that the trial is over: its page is told to load anew."""
    clock, desk, hall = make("t-2")
    stage, other = await enter(hall, clock), await enter(hall, clock, "token-t-2")
    heard, others = stage.join(), other.join()
    for one in (stage, other):
        one.play(1.0, stand)
    desk.over.add("t-1")
    assert await hall.writer.flush()
    assert heard.closed is not None
    assert heard.closed[0] == wire.CloseCode.NO_TRIAL
    assert set(hall.rooms) == {"t-2"}
    assert desk.chunks.get("t-1") is None
    assert others.closed is None


async def test_a_trial_opens_only_when_its_last_moments_are_stored() -> None:
    """A room that had a fault may not be opened from an older tick than it has played."""
    clock, desk, hall = make()
    stage = await enter(hall, clock)
    stage.join()
    stage.play(1.0, stand)
    hall._give_up(stage.room, RuntimeError("a fault"))
    desk.failures = 1
    with pytest.raises(StillStoring):
        await hall.enter(TOKEN)
    again = await hall.enter(TOKEN)
    assert again.world.tick == stage.room.world.tick


async def test_watching_the_numbers() -> None:
    """The hall exposes what the metrics page shows."""
    clock, desk, hall = make()
    stage = await enter(hall, clock)
    stage.room.join(Listener())
    await hall.writer.flush()
    assert hall.writer.commits == 1
    assert hall.ticker.lateness.total == 0
    assert desk.opened == 1
    assert wire.TICK_HZ == 30


async def test_a_trial_that_cannot_be_stored_does_not_hold_up_the_others(
    caplog: pytest.LogCaptureFixture,
) -> None:
    """Erased while it ran: after repeated failures it is given up, aloud; the rest is stored."""
    clock, desk, hall = make("t-2")
    gone, other = [await enter(hall, clock, f"token-{name}") for name in ("t-1", "t-2")]
    listeners = [gone.join(), other.join()]
    desk.erased.add("t-1")
    flushed = []
    for _ in range(5):
        gone.play(1.0, stand)
        other.play(1.0, stand)
        flushed.append(await hall.writer.flush())
    assert flushed == [False, False, False, True, True]
    assert listeners[0].closed is not None
    assert listeners[0].closed[0] == 1013
    assert listeners[1].closed is None
    assert list(hall.rooms) == ["t-2"]
    assert desk.chunks["t-2"][-1].last_tick == other.room.world.tick
    assert "the trial t-1 cannot be stored" in caplog.text


async def test_a_database_that_is_away_gives_no_trial_up() -> None:
    """When nothing can be stored, nobody is blamed, however long it lasts."""
    clock, desk, hall = make("t-2")
    stages = [await enter(hall, clock, f"token-{name}") for name in ("t-1", "t-2")]
    listeners = [stage.join() for stage in stages]
    desk.failures = 30
    for _ in range(8):
        stages[0].play(0.5, stand)
        assert not await hall.writer.flush()
    desk.failures = 0
    assert await hall.writer.flush()
    assert [listener.closed for listener in listeners] == [None, None]
    assert len(hall.rooms) == 2
