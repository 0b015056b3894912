"""What a room writes down of its trial until it is taken for storing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from server.live import wire
from server.live.clock import Clock
from server.live.lateness import Lateness
from server.live.ports import TrialBatch
from server.live.wire import PhaseName
from study.ar.elements import Display
from study.records.events import JournalEvent, Scalar
from study.records.journal import (
    HASH_EVERY_TICKS,
    JournalChunk,
    JournalRecorder,
    decode_ticks,
    encode_frames,
)
from study.records.quality import QualityFold, TrialQuality

if TYPE_CHECKING:
    from study.warehouse.world import World, WorldEvent

NO_FRAMES = bytes(1)
CLIENT_EVENTS_PER_S = 4.0
CLIENT_EVENTS_BURST = 60.0


class Chronicle:
    """The inputs, hashes and numbered events of one trial since they were last taken.

    Events that a client can cause at will are limited to 4 a second (bursts of 60); what exceeds
    that is dropped, so nobody can fill the database. `lateness` counts the ticks since the trial
    was last opened.
    """

    def __init__(
        self,
        trial_id: str,
        world: World,
        clock: Clock,
        recorder: JournalRecorder,
        next_number: int = 0,
    ) -> None:
        self._trial_id = trial_id
        self._world = world
        self._clock = clock
        self._recorder = recorder
        self._number = next_number
        self.lateness = Lateness()
        self._quality = QualityFold()
        self._events: list[JournalEvent] = []
        self._budget = CLIENT_EVENTS_BURST
        self._budget_s = clock.now_s()
        self._hashed_tick = -1

    def note(self, kind: str, data: Mapping[str, Scalar] | None = None) -> None:
        """Something happened at the present tick."""
        self._add(self._world.tick, kind, data or {})

    def note_client(self, kind: str, data: Mapping[str, Scalar]) -> None:
        """Something happened that a client may cause as often as it likes."""
        now_s = self._clock.now_s()
        gained = (now_s - self._budget_s) * CLIENT_EVENTS_PER_S
        self._budget = min(CLIENT_EVENTS_BURST, self._budget + gained)
        self._budget_s = now_s
        if self._budget >= 1.0:
            self._budget -= 1.0
            self.note(kind, data)

    def note_quality(self, report: wire.Quality) -> None:
        """The page measured its picture and its connection."""
        self.note_client(
            "quality",
            {
                "fps": " ".join(f"{rate:g}" for rate in report.fps),
                "rtt_ms": " ".join(f"{time_ms:.1f}" for time_ms in report.rtt_ms),
                "long_frames": report.long_frames,
                "longest_frame_ms": report.longest_frame_ms,
            },
        )

    def recall(self, journal: Sequence[JournalChunk], events: Sequence[JournalEvent]) -> None:
        """Take over, for the trial's quality, what was stored of it before it was reopened."""
        for chunk in journal:
            for frames in decode_ticks(chunk):
                self._quality.add_frames(frames)
        for event in events:
            self._quality.add_event(event)

    def add_tick(self, frames: Sequence[tuple[int, int]], last_seq: int) -> None:
        """The world made a tick with these frames."""
        recorder = self._recorder
        recorder.last_seq = last_seq
        self._quality.add_frames(frames)
        recorder.add_tick(encode_frames(frames) if frames else NO_FRAMES)
        if self._world.tick % HASH_EVERY_TICKS == 0:
            self._add_hash()

    def add_world_events(self, events: Sequence[WorldEvent]) -> None:
        """What the world did in its last tick."""
        for event in events:
            data = dict(event.data)
            if event.robot is not None:
                data["robot"] = event.robot
            self._add(event.tick, event.kind, data)

    def add_display(self, display: Display) -> None:
        """The display changed."""
        stations = "".join(str(balloon) for balloon in display.stations)
        self.note(
            "display_decided",
            {
                "robots": display.robots.hex(),
                "stations": stations,
                "overlays": int(display.overlays),
            },
        )

    def close(self) -> TrialQuality:
        """The trial is over: its last state is hashed, whatever its tick; how good it all was."""
        if self._hashed_tick != self._world.tick:
            self._add_hash()
        late = self.lateness
        p99_ms = late.quantile_ms(0.99) if late.total else None
        worst_ms = round(late.worst_s * 1000.0, 3) if late.total else None
        return self._quality.finish(self._clock.utc(), p99_ms, worst_ms)

    def take_batch(self, phase: PhaseName) -> TrialBatch | None:
        """Everything since the last call, or None when there is nothing."""
        chunk = self._recorder.take_chunk()
        if chunk is None and not self._events:
            return None
        events, self._events = tuple(self._events), []
        return TrialBatch(self._trial_id, chunk, events, self._world.tick, phase)

    def _add(self, tick: int, kind: str, data: Mapping[str, Scalar]) -> None:
        event = JournalEvent(self._number, tick, kind, self._clock.utc(), data)
        self._events.append(event)
        self._quality.add_event(event)
        self._number += 1

    def _add_hash(self) -> None:
        self._hashed_tick = self._world.tick
        self._recorder.add_hash(self._world.tick, self._world.state_hash())
