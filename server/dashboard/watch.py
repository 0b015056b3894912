"""What staff's pages may know and do of the running trials, without knowing the live loop."""

from __future__ import annotations

from dataclasses import dataclass

from server.live.hall import Hall
from server.live.room import Room
from server.live.wire import TICK_HZ
from study.errors import WrongMoment

LONGEST_EXTENSION_S = 24 * 3600.0


class NotRunning(WrongMoment):
    """The trial is not held in memory at the moment."""

    def __init__(self, trial_id: str) -> None:
        self.trial_id = trial_id
        super().__init__(
            "this trial is not running at the moment",
            next_step="It can be watched while its participant's page is open; one that has ended "
            "can be replayed.",
        )


@dataclass(frozen=True)
class RoomState:
    """A running trial as lists show it."""

    trial_id: str
    label: str
    phase: str
    is_connected: bool
    seconds: float
    cap_s: float
    sum_wait_s: float
    boxes: int
    boxes_total: int
    absent_s: float
    abandon_after_s: float


@dataclass(frozen=True)
class LoopState:
    """How the live loop is doing."""

    rooms: int
    running: int
    late_p99_ms: float
    ticks: int
    storage_failing_s: float | None


@dataclass(frozen=True)
class LiveWatch:
    """Looks at the hall of this process."""

    hall: Hall

    def describe(self, trial_id: str) -> RoomState | None:
        """The trial, if it is held in memory."""
        room = self.hall.rooms.get(trial_id)
        return None if room is None else _describe(room)

    def judge_loop(self) -> LoopState:
        """The loop's figures of now."""
        hall = self.hall
        failing = hall.writer.failing_since_s
        return LoopState(
            rooms=len(hall.rooms),
            running=sum(room.phase == "running" for room in hall.rooms.values()),
            late_p99_ms=hall.ticker.lateness.quantile_ms(0.99),
            ticks=hall.ticker.lateness.total,
            storage_failing_s=None if failing is None else hall.clock.now_s() - failing,
        )

    def last_tick(self, trial_id: str) -> int:
        """The tick of a trial in memory; 0 for any other."""
        room = self.hall.rooms.get(trial_id)
        return 0 if room is None else int(room.world.tick)

    def require_running(self, trial_id: str) -> None:
        """Raise `NotRunning` unless the trial is held in memory."""
        if trial_id not in self.hall.rooms:
            raise NotRunning(trial_id)

    def set_limit(self, trial_id: str, limit_s: float) -> None:
        """Wait so long for an absent participant; a trial that has just left memory is let be."""
        room = self.hall.rooms.get(trial_id)
        if room is not None:
            room.abandon_after_s = limit_s


def _describe(room: Room) -> RoomState:
    world, setup = room.world, room.setup
    waits = world.motion.robots
    return RoomState(
        trial_id=setup.trial_id,
        label=setup.label,
        phase=room.phase,
        is_connected=room.is_joined,
        seconds=world.tick / TICK_HZ,
        cap_s=setup.spec.cap_s,
        sum_wait_s=float((waits["waited_ticks"] + waits["wait_ticks"]).sum()) / TICK_HZ,
        boxes=int(world.boxes_delivered),
        boxes_total=setup.spec.boxes_total,
        absent_s=room.presence.absent_s(),
        abandon_after_s=room.abandon_after_s,
    )
