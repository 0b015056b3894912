"""Guards a whole trial at `study` scale through the live path: exact, complete, small."""

import pytest

from server.bench.wire import measure_wire
from server.live import wire
from study.headless import simulate_trial
from study.warehouse.layout import PRESETS, build_layout

from .stage import Stage


def test_live_and_headless_end_in_the_same_state() -> None:
    """A simulated worker's inputs sent frame by frame: the same ticks, the same bits, all boxes."""
    for scale in ("practice", "study"):
        layout = build_layout(PRESETS[scale])
        trial = simulate_trial(layout, 11, "cyclic", keep_inputs=True)
        assert trial.inputs is not None
        stage = Stage.open(scale=scale, spec=PRESETS[scale], seed=11)
        listener = stage.join(is_ready=False)
        stage.room.take_ready()
        stage.clock.pass_s(wire.COUNTDOWN_S)
        stage.room.advance()
        for keys, yaw in trial.inputs.tolist():
            stage.send((keys, yaw))
            stage.run(1 / 30)
        result = stage.room.result
        assert result is not None
        assert result.status == "completed"
        assert result.ticks == trial.measures.ticks
        assert result.state_hash == trial.state_hash
        assert result.measures == trial.measures
        assert listener.texts[-1]["phase"] == "finished"


@pytest.mark.parametrize("condition", ["varil", "crmiar"])
def test_a_participant_costs_at_most_one_and_a_half_kilobytes_a_second(condition: str) -> None:
    """Payload and frame headers over a whole trial with everything shown."""
    report = measure_wire(condition)
    assert report["status"] == "completed"
    assert report["bytes_per_s"] <= 1500
    assert report["by_kind"]["plans"] > 0
