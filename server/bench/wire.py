"""Exact wire bytes of a trial: a whole one, played in simulated time by a recorded walker."""

from __future__ import annotations

import asyncio
from datetime import UTC, datetime, timedelta
from typing import Any

from server.live import wire
from server.live.opening import open_room
from server.live.ports import OpenTrial, TrialSetup
from server.policy_files import shipped_policy
from study.headless import simulate_trial
from study.warehouse.halls import PRESETS
from study.warehouse.layout import build_layout

PERIOD_S = 1 / 30
SHORT_FRAME_BYTES = 125


def record_walk(seed: int = 1) -> list[tuple[int, int]]:
    """The input frames of a simulated worker's trial at `study` scale, one per tick."""
    trial = simulate_trial(build_layout(PRESETS["study"]), seed, "cyclic", keep_inputs=True)
    frames = [] if trial.inputs is None else trial.inputs.tolist()
    return [(int(keys), int(yaw)) for keys, yaw in frames]


class TurnedClock:
    """A clock that is turned by hand."""

    def __init__(self) -> None:
        self.at_s = 0.0

    def now_s(self) -> float:
        """Seconds turned so far."""
        return self.at_s

    def utc(self) -> datetime:
        """The same as a time of day."""
        return datetime(2000, 1, 1, tzinfo=UTC) + timedelta(seconds=self.at_s)


class ByteCounter:
    """A sink that counts payloads and WebSocket frame headers by kind of message."""

    def __init__(self) -> None:
        self.bytes = {"welcome": 0, "snapshots": 0, "plans": 0, "displays": 0, "texts": 0}

    def send_text(self, text: str) -> None:
        """Count a text message; the welcome apart, which comes once."""
        self._count("welcome" if '"welcome"' in text[:20] else "texts", len(text.encode()))

    def send_control(self, data: bytes) -> None:
        """Count a plan or a display."""
        self._count("plans" if data[0] == wire.PLAN else "displays", len(data))

    def send_snapshot(self, data: bytes) -> None:
        """Count a snapshot; a fast client is sent every one."""
        self._count("snapshots", len(data))

    def send_finished(self) -> None:
        """Too short to matter."""

    def close(self, code: int, reason: str) -> None:
        """Too short to matter."""

    def _count(self, kind: str, length: int) -> None:
        self.bytes[kind] += length + (2 if length <= SHORT_FRAME_BYTES else 4)


def measure_wire(condition: str, seed: int = 1) -> dict[str, Any]:
    """Bytes per second to one participant over a whole trial at `study` scale, by kind."""
    clock, counter = TurnedClock(), ByteCounter()
    setup = TrialSetup(
        trial_id="wire",
        kind="trial",
        scale="study",
        spec=PRESETS["study"],
        seed=seed,
        condition=condition,
        policy=shipped_policy(),
        label="Display A",
        mode="pilot",
    )
    room = asyncio.run(open_room(OpenTrial(setup), clock))
    room.join(counter)
    room.take_ready()
    clock.at_s += wire.COUNTDOWN_S
    room.advance()
    walk = record_walk(seed)
    for seq, frame in enumerate(walk, 1):
        room.take_input(wire.Input(seq, (frame,)))
        clock.at_s += PERIOD_S
        room.advance()
    seconds = room.world.tick * PERIOD_S
    running = {kind: count for kind, count in counter.bytes.items() if kind != "welcome"}
    return {
        "trial_s": round(seconds, 1),
        "status": room.world.status,
        "bytes_per_s": round(sum(running.values()) / seconds, 1),
        "by_kind": {kind: round(count / seconds, 1) for kind, count in running.items()},
        "welcome_bytes": counter.bytes["welcome"],
    }
