"""Guards a trial's life in its room, in fake time: phases, input, storing, exact resumption."""

import asyncio

import pytest

from server.live import wire
from server.live.opening import open_room
from server.live.ports import OpenTrial
from study.records.events import check_event
from study.records.journal import replay
from study.warehouse.layout import PRESETS, build_layout
from study.warehouse.world import World

from .stage import SETUP, FakeClock, Listener, Stage, serve_stations, stand


def forward(world: World) -> tuple[int, int]:
    return 1, 0


def test_a_practice_trial_is_completed() -> None:
    """From welcome to result: one box delivered, the robot home, every event in the dictionary."""
    stage = Stage.open()
    listener = stage.join()
    stage.play_to_end(serve_stations)
    result = stage.room.result
    assert result is not None
    assert (result.status, result.measures.boxes_delivered) == ("completed", 1)
    assert result.ticks == stage.room.world.tick == result.measures.ticks
    assert listener.phases() == [
        ("waiting", "start"),
        ("countdown", "start"),
        ("running", "start"),
        ("finished", "completed"),
    ]
    assert {"type": "delivered", "boxes": 1} in listener.texts
    batch = stage.room.take_batch()
    assert batch is not None
    assert [event.number for event in batch.events] == list(range(len(batch.events)))
    for event in batch.events:
        check_event(event.kind, event.data)
    stage.room.finish_stored()
    assert listener.is_finished


def test_the_welcome_tells_all_the_client_needs() -> None:
    """And nothing about the condition or the seed."""
    stage = Stage.open()
    welcome = stage.join(is_ready=False).texts[0]
    assert welcome["type"] == "welcome"
    assert (welcome["robots"], welcome["boxes_total"], welcome["cap_s"]) == (1, 1, 180.0)
    assert len(welcome["hall"]["shelves_m"]) == 6
    assert len(welcome["hall"]["stations"]) == 4
    text = str(welcome).lower()
    assert not any(word in text for word in ("varil", "arroch", "crmiar", "policy", "'seed'"))


def test_the_same_inputs_give_the_same_trial_from_the_journal() -> None:
    """Configuration + seed + stored inputs, with pauses between, give every state hash again."""
    stage = Stage.open()
    listener = stage.join()
    for _ in range(4):
        stage.play(3.7, serve_stations)
        stage.room.leave(listener, 1006)
        stage.run(2.0)
        listener = stage.join()
    stage.play_to_end(serve_stations)
    batch = stage.room.take_batch()
    assert batch is not None
    assert batch.chunk is not None
    checked: list[tuple[int, bool]] = []
    world = World(build_layout(PRESETS["practice"]), SETUP.seed)
    for _ in replay(world, [batch.chunk], lambda tick, equal: checked.append((tick, equal))):
        pass
    assert len(checked) >= batch.chunk.ticks // 30
    assert all(equal for _, equal in checked)
    assert checked[-1][0] == stage.room.world.tick, "the last tick is hashed, whatever its number"
    assert stage.room.result is not None
    assert world.state_hash() == stage.room.result.state_hash


def test_a_reopened_trial_goes_on_as_if_nothing_had_happened() -> None:
    """A server that died after a commit: the twin that never stopped ends in the same state."""
    ends = []
    for is_killed in (False, True):
        stage = Stage.open()
        stage.join()
        chunks, events = [], []
        for _ in range(6):
            stage.play(2.0, serve_stations)
            batch = stage.room.take_batch()
            assert batch is not None
            assert batch.chunk is not None
            chunks.append(batch.chunk)
            events += batch.events
            if is_killed:
                trial = OpenTrial(SETUP, tuple(chunks), tuple(events))
                shown = stage.room.world.tick
                stage = Stage.open(stage.clock, trial)
                assert (stage.room.phase, stage.room.world.tick) == ("paused", shown)
                join_at_once(stage)
        stage.play_to_end(serve_stations)
        assert stage.room.result is not None
        ends.append((stage.room.result.ticks, stage.room.result.state_hash))
    assert ends[0] == ends[1]


def join_at_once(stage: Stage) -> Listener:
    """Join and let the countdown end without a tick in which no frame was sent."""
    listener = stage.join(is_ready=False)
    stage.room.take_ready()
    stage.clock.pass_s(wire.COUNTDOWN_S)
    stage.room.advance()
    assert stage.room.phase == "running"
    return listener


def test_event_numbers_and_sequence_go_on_after_reopening() -> None:
    """Numbers never repeat, so batches that arrive twice can be told apart."""
    stage = Stage.open()
    stage.join()
    stage.play(2.0, forward)
    batch = stage.room.take_batch()
    assert batch is not None
    assert batch.chunk is not None
    again = Stage.open(stage.clock, OpenTrial(SETUP, (batch.chunk,), batch.events))
    welcome = again.join(is_ready=False).texts[0]
    assert welcome["acknowledged_seq"] == batch.chunk.last_seq > 0
    assert welcome["tick"] == stage.room.world.tick
    later = again.room.take_batch()
    assert later is not None
    assert later.chunk is None
    assert later.events[0].number == batch.events[-1].number + 1
    assert later.events[0].data == {"resumed": True}


def test_a_trial_that_ended_before_its_result_was_stored_ends_again() -> None:
    """The server died between the last commit and the result."""
    stage = Stage.open()
    stage.join()
    stage.play_to_end(serve_stations)
    batch = stage.room.take_batch()
    assert batch is not None
    assert batch.chunk is not None
    room = asyncio.run(open_room(OpenTrial(SETUP, (batch.chunk,), batch.events), stage.clock))
    assert room.phase == "finished"
    assert room.result is not None
    assert stage.room.result is not None
    assert room.result.state_hash == stage.room.result.state_hash


def test_sending_faster_moves_nobody_farther() -> None:
    """Three frames a tick cover the ground of one a tick plus eight frames."""
    walked = []
    for per_tick in (1, 3):
        stage = Stage.open()
        stage.join()
        start_m = stage.room.world.human_x_m
        for _ in range(20):
            stage.send(*[(1, 0)] * per_tick)
            stage.run(1 / 30)
        walked.append(stage.room.world.human_x_m - start_m)
    step_m = 1.4 / 30
    assert walked[0] == pytest.approx(20 * step_m)
    assert walked[1] <= walked[0] + (8 + 4) * step_m
    assert walked[1] > walked[0]


def test_input_before_ready_is_refused() -> None:
    stage = Stage.open()
    stage.join(is_ready=False)
    with pytest.raises(wire.WireError, match="wanted “ready” before any input"):
        stage.send((1, 0))


def test_input_in_the_countdown_is_dropped() -> None:
    """It neither moves anybody nor is it acknowledged."""
    stage = Stage.open()
    stage.join(is_ready=False)
    stage.room.take_ready()
    stage.send((1, 0), (1, 0))
    stage.run(3.2)
    assert stage.room.world.tick > 0
    assert stage.room.world.human_x_m == stage.room.world.layout.human_start_m[0]
    batch = stage.room.take_batch()
    assert batch is not None
    assert batch.chunk is not None
    assert batch.chunk.last_seq == 0


def test_time_scale_makes_more_ticks_not_more_snapshots() -> None:
    """Four times real time: 120 ticks a second, still 15 snapshots."""
    stage = Stage.open(time_scale=4.0)
    listener = stage.join()
    before, tick = len(listener.snapshots), stage.room.world.tick
    stage.run(2.0)
    assert stage.room.world.tick - tick == 240
    assert len(listener.snapshots) - before == 30


def test_plans_are_sent_only_where_an_element_needs_them() -> None:
    """Under `none` no planned path leaves the server; under the initial policy it does."""
    for condition, expected in (("none", 0), ("varil", 1)):
        stage = Stage.open(condition=condition)
        listener = stage.join()
        stage.play(15.0, stand)
        plans = [data for data in listener.controls if data[0] == wire.PLAN]
        assert bool(plans) == bool(expected), condition
        displays = [data for data in listener.controls if data[0] == wire.DISPLAY]
        assert displays[0] == bytes([4, 0, 1, 7 * expected, 4, *[expected] * 4])


def test_watchers_see_and_do_nothing() -> None:
    """A read-only listener is welcomed, follows, and its end pauses nobody."""
    stage = Stage.open()
    stage.join()
    watcher = Listener()
    stage.room.watch(watcher)
    stage.play(1.0, forward)
    assert watcher.texts[0]["type"] == "welcome"
    assert len(watcher.snapshots) > 10
    stage.room.leave(watcher, 1001)
    assert stage.room.phase == "running"


def test_nobody_can_flood_the_events() -> None:
    """A thousand changes of attention in a moment: sixty are stored."""
    stage = Stage.open()
    stage.join()
    for turn in range(1000):
        stage.room.take_attention(wire.Attention(turn % 2 == 0, True, True))
    batch = stage.room.take_batch()
    assert batch is not None
    assert sum(event.kind == "attention" for event in batch.events) == 60


def test_a_server_that_stops_pauses_and_asks_to_come_back() -> None:
    stage = Stage.open(clock=FakeClock())
    listener = stage.join()
    stage.play(1.0, forward)
    stage.room.shut_down(wire.CloseCode.RESTARTING, "back soon")
    assert listener.closed == (1012, "back soon")
    assert stage.room.phase == "paused"
