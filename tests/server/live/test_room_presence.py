"""Guards what a room does when its participant is silent, gone, back, or in two tabs at once."""

from dataclasses import replace

import pytest

from server.live import wire
from server.live.ports import OpenTrial
from study.warehouse.world import World

from .stage import SETUP, Stage, stand


def forward(world: World) -> tuple[int, int]:
    return 1, 0


def test_a_silent_client_stands_still_and_is_noted() -> None:
    """No frames: the world goes on, the human stands; the event comes after 250 ms, once."""
    stage = Stage.open()
    stage.join()
    stage.play(1.0, forward)
    x_m, tick = stage.room.world.human_x_m, stage.room.world.tick
    stage.run(2.0)
    assert stage.room.world.human_x_m - x_m < 0.1, "at most the frames that waited"
    assert stage.room.world.tick == tick + 60
    stage.play(0.5, forward)
    batch = stage.room.take_batch()
    assert batch is not None
    events = {event.kind: event for event in batch.events}
    kinds = [event.kind for event in batch.events]
    assert kinds.count("input_silent") == kinds.count("input_resumed") == 1
    assert 6 <= events["input_silent"].tick - tick <= 9
    assert events["input_resumed"].data["silent_s"] == pytest.approx(2.03, abs=0.04)


def test_long_silence_pauses_and_a_shown_page_goes_on() -> None:
    """A hidden page does not resume by its pings; showing it again does, with a countdown."""
    stage = Stage.open()
    listener = stage.join()
    stage.play(1.0, stand)
    stage.room.take_attention(wire.Attention(visible=False, focused=False, locked=False))
    stage.run(5.2)
    assert stage.room.phase == "paused"
    stage.room.take_ping()
    assert stage.room.phase == "paused"
    stage.room.take_input(wire.Input(stage.seq + 1, ((1, 0),)))
    stage.room.take_attention(wire.Attention(visible=True, focused=True, locked=False))
    assert stage.room.phase == "countdown"
    stage.run(3.1)
    assert listener.phases()[-3:] == [
        ("paused", "disconnected"),
        ("countdown", "resume"),
        ("running", "resume"),
    ]


def test_silence_does_not_pause_where_the_study_goes_on() -> None:
    stage = Stage.open(on_disconnect="continue")
    listener = stage.join()
    stage.run(8.0)
    assert stage.room.phase == "running"
    stage.room.leave(listener, 1006)
    stage.run(1.0)
    assert stage.room.phase == "running"
    tick = stage.room.world.tick
    newcomer = stage.join(is_ready=False)
    assert newcomer.phases() == [("running", "start")]
    assert newcomer.texts[0]["tick"] == tick


def test_a_newer_tab_takes_over() -> None:
    """The older one is told 4409; what it still says or its end changes nothing."""
    stage = Stage.open()
    older = stage.join()
    stage.play(1.0, forward)
    newer = stage.join(is_ready=False)
    assert older.closed == (4409, "this trial goes on in a newer tab")
    assert (stage.room.phase, newer.phases()) == ("paused", [("paused", "disconnected")])
    stage.room.leave(older, 4409)
    stage.room.take_ready()
    stage.run(3.1)
    assert stage.room.phase == "running"
    assert newer.closed is None
    assert len(older.snapshots) < len(newer.snapshots) + 40


def test_leaving_in_the_countdown_returns_to_where_it_was() -> None:
    stage = Stage.open()
    listener = stage.join(is_ready=False)
    stage.room.take_ready()
    stage.run(1.0)
    stage.room.leave(listener, 1001)
    assert stage.room.phase == "waiting"
    stage.run(5.0)
    assert stage.room.world.tick == 0


def test_nobody_back_in_time_abandons_the_trial() -> None:
    stage = Stage.open(abandon_after_s=60.0)
    listener = stage.join()
    stage.play(1.0, stand)
    stage.room.leave(listener, 1001)
    stage.run(59.0)
    assert stage.room.result is None
    stage.run(2.0)
    assert stage.room.result is not None
    assert stage.room.result.status == "abandoned"


def test_time_away_counts_across_a_restart() -> None:
    """The trial's last event tells since when nobody was there."""
    stage = Stage.open(abandon_after_s=60.0)
    listener = stage.join()
    stage.play(1.0, stand)
    stage.room.leave(listener, 1001)
    batch = stage.room.take_batch()
    assert batch is not None
    assert batch.chunk is not None
    setup = replace(SETUP, abandon_after_s=60.0)
    stage.clock.pass_s(45.0)
    again = Stage.open(stage.clock, OpenTrial(setup, (batch.chunk,), batch.events))
    again.run(14.0)
    assert again.room.result is None
    again.run(2.0)
    assert again.room.result is not None
    assert again.room.result.status == "abandoned"


def test_a_mute_socket_is_closed() -> None:
    """Connected but without a word for two minutes: 4408."""
    stage = Stage.open()
    listener = stage.join(is_ready=False)
    stage.run(121.0)
    assert listener.closed is not None
    assert listener.closed[0] == 4408
