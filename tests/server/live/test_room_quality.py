"""Guards that a trial's result says how good its conditions were, also after a restart."""

from dataclasses import replace

from server.live import wire
from server.live.ports import OpenTrial
from study.records.quality import TrialQuality

from .stage import SETUP, FakeClock, Stage

REPORT = wire.Quality((60.0, 58.0), (20.0, 30.0), 1, 66.0)


def played(is_restarted: bool) -> TrialQuality:
    """Ten idle seconds with a report, then nobody returns; in between the server may restart."""
    clock = FakeClock()
    setup = replace(SETUP, abandon_after_s=60.0)
    stage = Stage.open(clock, OpenTrial(setup))
    listener = stage.join()
    stage.room.take_attention(wire.Attention(True, True, True))
    stage.play(10.0)
    stage.room.note_late(0.004)
    stage.room.take_quality(REPORT)
    if is_restarted:
        batch = stage.room.take_batch()
        assert batch is not None
        assert batch.chunk is not None
        stage = Stage.open(clock, OpenTrial(setup, (batch.chunk,), batch.events))
    else:
        stage.room.leave(listener, 1006)
    stage.run(61.0)
    assert stage.room.result is not None
    assert stage.room.result.quality is not None
    return stage.room.result.quality


def test_the_result_tells_the_quality() -> None:
    quality = played(is_restarted=False)
    assert (quality.frame_rate_median_hz, quality.rtt_median_ms) == (59.0, 25.0)
    assert (quality.long_frames, quality.longest_frame_ms, quality.reports) == (1, 66.0, 1)
    assert (quality.pauses, quality.connections, quality.pointer_lock_losses) == (1, 1, 0)
    assert 59.0 < quality.paused_s < 62.0
    assert 9.5 < quality.idle_s <= 10.1
    assert quality.tick_late_max_ms == 4.0


def test_a_restart_of_the_server_loses_none_of_it() -> None:
    """But the lateness of ticks, which is counted since the trial was last opened."""
    once, again = played(is_restarted=False), played(is_restarted=True)
    assert again.tick_late_max_ms is None
    for name in ("idle_s", "reports", "pauses", "rtt_p95_ms", "frame_rate_p5_hz", "connections"):
        assert getattr(once, name) == getattr(again, name), name


def test_a_flood_of_reports_does_not_fill_the_journal() -> None:
    stage = Stage.open()
    stage.join()
    for _ in range(500):
        stage.room.take_quality(REPORT)
    batch = stage.room.take_batch()
    assert batch is not None
    assert sum(event.kind == "quality" for event in batch.events) <= 61
