"""Guards lock-step: one tick a frame, one snapshot a message, for simulated participants alone."""

import json
from dataclasses import replace

import pytest
from websockets.asyncio.client import connect

from server.live import wire
from server.live.lock_step import LockStepRoom
from server.live.room import Room
from study.errors import NotAllowedLive
from study.headless import simulate_trial
from study.warehouse.layout import PRESETS, build_layout

from .line import Serving, read_text
from .stage import SETUP, Listener, Stage


def enter(stage: Stage) -> Listener:
    """A bot's socket joins and is ready."""
    listener = Listener()
    stage.room.join(listener)
    stage.room.take_ready()
    return listener


def test_each_message_advances_by_its_frames_and_is_answered_once() -> None:
    """No countdown, no time needed; frames sent twice count once."""
    stage = Stage.open(mode="bot")
    listener = enter(stage)
    assert stage.room.phase == "running"
    before = len(listener.snapshots)
    for count in (8, 1, 3):
        tick = stage.room.world.tick
        stage.send(*[(1, 0)] * count)
        assert stage.room.world.tick == tick + count
    assert len(listener.snapshots) == before + 3
    stage.room.take_input(wire.Input(1, ((1, 0),) * 8))
    assert stage.room.world.tick == 12


def test_time_moves_nothing() -> None:
    """The ticker may call as often as it likes."""
    stage = Stage.open(mode="bot")
    listener = enter(stage)
    before = len(listener.snapshots)
    stage.run(20.0)
    assert (stage.room.world.tick, stage.room.phase) == (0, "running")
    assert len(listener.snapshots) == before


def test_a_trial_in_lock_step_ends_in_the_state_of_a_headless_one() -> None:
    """Eight frames a message: the same ticks and the same bits."""
    trial = simulate_trial(build_layout(PRESETS["practice"]), 11, "cyclic", keep_inputs=True)
    assert trial.inputs is not None
    stage = Stage.open(mode="bot", scale="practice", spec=PRESETS["practice"], seed=11)
    enter(stage)
    frames = [tuple(frame) for frame in trial.inputs.tolist()]
    for first in range(0, len(frames), 8):
        stage.send(*frames[first : first + 8])
    result = stage.room.result
    assert result is not None
    assert (result.ticks, result.state_hash) == (trial.measures.ticks, trial.state_hash)


def test_who_goes_away_finds_the_world_where_it_was() -> None:
    """Also in a study whose trials go on without live participants; long absence ends it."""
    stage = Stage.open(mode="bot", on_disconnect="continue", abandon_after_s=60.0)
    listener = enter(stage)
    stage.send(*[(1, 0)] * 8)
    stage.room.leave(listener, 1001)
    assert stage.room.phase == "paused"
    enter(stage)
    stage.seq = 8
    stage.send((1, 0))
    assert stage.room.world.tick == 9
    stage.room.leave(stage.room._participant, 1001)  # type: ignore[arg-type]
    stage.run(61.0)
    assert stage.room.result is not None
    assert stage.room.result.status == "abandoned"


@pytest.mark.parametrize("mode", ["live", "pilot", "learning"])
def test_nobody_else_plays_in_lock_step(mode: str) -> None:
    """Their rooms have time of their own, and the other kind refuses them."""
    stage = Stage.open(mode=mode)
    assert type(stage.room) is Room
    with pytest.raises(NotAllowedLive):
        LockStepRoom(replace(SETUP, mode=mode))


async def test_no_socket_makes_its_room_go_in_lock_step(serving: Serving) -> None:
    """Claims in the address, the headers and every message; the room stays with the clock."""
    claims = {"mode": "bot", "is_bot": True, "lock_step": True, "time_scale": 4}
    query = "&".join(f"{name}={value}" for name, value in claims.items())
    headers = {f"X-{name.replace('_', '-')}": str(value) for name, value in claims.items()}
    address = f"ws://127.0.0.1:{serving.port}/p/token-t-1/live?{query}"
    async with connect(address, additional_headers=headers) as ws:
        await ws.send(json.dumps({"type": "hello", "version": 1} | claims))
        await read_text(ws, "welcome")
        await ws.send(json.dumps({"type": "ready"} | claims))
        assert (await read_text(ws, "phase"))["phase"] == "waiting"
        room = serving.hall.rooms["t-1"]
        assert (type(room), room.setup.mode) == (Room, "live")
        assert room.setup is serving.desk.setups["token-t-1"]
