"""One trial: its inbox, its steps, its journal, its phases. It knows no socket and no database.

Phases: waiting (nobody was ready yet) -> countdown -> running -> finished, and running -> paused
-> countdown -> running whenever the participant is gone and the study says so. Within a tick the
order is: inputs -> step -> events -> decision -> display.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from server.live import wire
from server.live.audience import Audience
from server.live.chronicle import Chronicle
from server.live.clock import Clock
from server.live.inbox import Inbox
from server.live.ports import Outcome, TrialBatch, TrialResult, TrialSetup
from server.live.presence import Presence
from server.live.sink import Sink
from server.live.wire import CloseCode, PhaseName, PhaseReason

if TYPE_CHECKING:
    from study.ar.display import DisplaySource
    from study.warehouse.world import World

ENDINGS: dict[str, tuple[PhaseReason, Outcome]] = {
    "completed": ("completed", "completed"),
    "timed_out": ("timed_out", "timed_out"),
}


class Room:
    """A running trial, driven by `advance` and by what its participant's socket hands in.

    `result` is set once the trial is over; `finish_stored` is called when it is kept for good.
    """

    def __init__(
        self,
        setup: TrialSetup,
        world: World,
        display: DisplaySource,
        chronicle: Chronicle,
        inbox: Inbox,
        clock: Clock,
    ) -> None:
        self.setup = setup
        self.world = world
        self.phase: PhaseName = "waiting" if world.tick == 0 else "paused"
        self.result: TrialResult | None = None
        self._display = display
        self._chronicle = chronicle
        self._inbox = inbox
        self._clock = clock
        self._audience = Audience(setup, world)
        self._audience.show(display.display)
        self._participant: Sink | None = None
        self.presence = Presence(clock)
        self._is_ready = False
        self._reason: PhaseReason = "start" if world.tick == 0 else "resume"
        self._countdown_end_s = 0.0
        self._credit = 0.0
        self._is_snapshot_turn = False
        self.abandon_after_s = setup.abandon_after_s

    # ---- what a socket hands in -------------------------------------------------------------

    def join(self, sink: Sink) -> None:
        """A participant's socket takes the trial over; an older one is closed."""
        older = self._participant
        if older is not None:
            self._chronicle.note("taken_over")
            self._audience.remove(older)
            older.close(CloseCode.TAKEN_OVER, "this trial goes on in a newer tab")
            self._stop_running()
        self._chronicle.note("connected")
        self._participant = sink
        self._is_ready = False
        self._inbox.clear()
        self.presence.arrive()
        self._audience.add(sink, self._inbox.acknowledged_seq)
        sink.send_text(self._phase_text())

    def leave(self, sink: Sink, code: int) -> None:
        """A socket closed; ignored unless it is the participant's present one."""
        self._audience.remove(sink)
        if sink is not self._participant:
            return
        self._participant = None
        self.presence.leave()
        self._chronicle.note("disconnected", {"code": code})
        self._inbox.clear()
        self._stop_running()

    @property
    def is_joined(self) -> bool:
        """Whether a participant's socket is there."""
        return self._participant is not None

    def watch(self, sink: Sink) -> None:
        """A read-only listener: sees what the participant's client is sent."""
        self._audience.add(sink, self._inbox.acknowledged_seq)
        sink.send_text(self._phase_text())

    def take_ready(self) -> None:
        """The client has drawn its first frame, or wants to go on: the countdown starts."""
        self._is_ready = True
        self.presence.hear()
        self._go_on()

    def take_input(self, message: wire.Input) -> None:
        """Queue input frames; dropped unless the world runs. WireError when they come too early."""
        if self.phase != "running":
            if not self._is_ready:
                raise wire.WireError("“ready” before any input", "an input message")
            self.presence.hear()
            return
        self._inbox.put(message)
        silent_s = self.presence.hear_input()
        if silent_s is not None:
            self._chronicle.note_client("input_resumed", {"silent_s": round(silent_s, 3)})

    def take_attention(self, message: wire.Attention) -> None:
        """Store whether the page is shown, focused and holds the pointer."""
        self._chronicle.note_client(
            "attention",
            {"visible": message.visible, "focused": message.focused, "locked": message.locked},
        )
        self.presence.is_page_shown = message.visible
        self.take_ping()

    def take_context(self, message: wire.Context) -> None:
        """Store that the graphics context was lost or restored."""
        self.presence.hear()
        self._chronicle.note_client("context", {"lost": message.lost})

    def take_quality(self, message: wire.Quality) -> None:
        """Store what the page measured of its picture and connection."""
        self.presence.hear()
        self._chronicle.note_quality(message)

    def take_ping(self) -> None:
        """The page is alive; a world that paused because it was silent goes on."""
        self.presence.hear()
        if self._is_ready and self.presence.is_page_shown:
            self._go_on()

    # ---- time -------------------------------------------------------------------------------

    def advance(self) -> None:
        """Called every 1/30 s: as many ticks as the time scale asks for, at most one snapshot."""
        if self.phase == "running":
            self._check_input()
        if self.phase == "running":
            self._credit += self.setup.time_scale
            while self._credit >= 1.0 and self.phase == "running":
                self._credit -= 1.0
                self.step()
            self._is_snapshot_turn = not self._is_snapshot_turn
            if self._is_snapshot_turn or self.phase != "running":
                self._audience.send_snapshot(self._inbox.acknowledged_seq)
        elif self.phase == "countdown":
            if self._clock.now_s() >= self._countdown_end_s:
                self._start_running()
        elif self.phase != "finished":
            self._check_absence()

    def step(self) -> None:
        """One tick of the world."""
        world, chronicle = self.world, self._chronicle
        frames = self._inbox.take(world.tick + 1)
        events = world.step(frames)
        chronicle.add_tick(frames, self._inbox.acknowledged_seq)
        if events:
            chronicle.add_world_events(events)
            if any(event.kind == "box_delivered" for event in events):
                self._audience.tell(wire.encode_delivered(int(world.boxes_delivered)))
        if self._inbox.discarded:
            self._note_discarded()
        display = self._display.update(world)
        if display is not None:
            chronicle.add_display(display)
            self._audience.show(display)
        if world.status != "running":
            reason, outcome = ENDINGS[world.status]
            self._finish(reason, outcome)

    def note_lag(self, lost_s: float) -> None:
        """The server was late for so long that it did not make it up."""
        if self.phase == "running":
            self._chronicle.note("lagged", {"lost_s": round(lost_s, 3)})

    def note_late(self, late_s: float) -> None:
        """The tick that comes now is so much later than it should be."""
        if self.phase == "running":
            self._chronicle.lateness.add(late_s)

    def resume(self, absent_s: float, was_abandoned: bool) -> None:
        """The trial was reopened from its journal; nobody had been there for so long.

        One that had already ended, but whose result was not stored yet, ends again.
        """
        self.presence.backdate_absence(absent_s)
        if self.world.status != "running":
            self._finish(*ENDINGS[self.world.status])
        elif was_abandoned:
            self._finish("timed_out", "abandoned")

    # ---- storing ----------------------------------------------------------------------------

    def take_batch(self) -> TrialBatch | None:
        """What happened since the last call, or None."""
        return self._chronicle.take_batch(self.phase)

    def note_committed(self, batch: TrialBatch) -> None:
        """This is stored for good. Nobody in an ordinary trial waits for that."""

    def finish_stored(self) -> None:
        """The result is kept: everybody may go on."""
        for sink in self._audience.sinks:
            sink.send_finished()

    def shut_down(self, code: CloseCode, reason: str) -> None:
        """The server stops, or gives this trial up for now: pause, and say why."""
        if self.phase in ("running", "countdown"):
            self._pause("shutdown")
        self._participant = None
        for sink in self._audience.sinks:
            self._audience.remove(sink)
            sink.close(code, reason)

    # ---- phases -----------------------------------------------------------------------------

    def _go_on(self) -> None:
        if self.phase not in ("waiting", "paused"):
            return
        seconds = wire.COUNTDOWN_S / self.setup.time_scale
        self._countdown_end_s = self._clock.now_s() + seconds
        self._chronicle.note("countdown_started")
        self._change_phase("countdown", "start" if self.world.tick == 0 else "resume")

    def _start_running(self) -> None:
        self._inbox.clear()
        self.presence.expect_input()
        self._credit = 0.0
        self._chronicle.note("started", {"seq": self._inbox.acknowledged_seq})
        self._change_phase("running", self._reason)

    def _stop_running(self) -> None:
        """The participant's socket is gone."""
        if self.phase == "countdown":
            self._change_phase("waiting" if self.world.tick == 0 else "paused", "disconnected")
        elif self.phase == "running" and self.setup.on_disconnect == "pause":
            self._pause("disconnected")

    def _pause(self, cause: str) -> None:
        self._inbox.clear()
        self._chronicle.note("paused", {"reason": cause})
        self._change_phase("paused", "disconnected")
        self._audience.send_snapshot(self._inbox.acknowledged_seq)

    def _finish(self, reason: PhaseReason, outcome: Outcome) -> None:
        world, now = self.world, self._clock.utc()
        quality = self._chronicle.close()
        self.result = TrialResult(
            outcome, world.tick, world.state_hash(), now, world.measures(), quality
        )
        self._change_phase("finished", reason)

    def _change_phase(self, phase: PhaseName, reason: PhaseReason) -> None:
        self.phase, self._reason = phase, reason
        self._audience.tell(self._phase_text())

    def _phase_text(self) -> str:
        left_s = max(0.0, self._countdown_end_s - self._clock.now_s())
        return wire.encode_phase(
            self.phase, self.world.tick, self._reason, self._inbox.acknowledged_seq, left_s
        )

    # ---- silence ----------------------------------------------------------------------------

    def _check_input(self) -> None:
        verdict = self.presence.check_input()
        if verdict == "silent":
            self._chronicle.note_client("input_silent", {})
        elif verdict == "too long" and self.setup.on_disconnect == "pause":
            self._pause("silent")

    def _check_absence(self) -> None:
        if self._participant is not None and self.presence.is_mute():
            sink = self._participant
            self.leave(sink, CloseCode.SILENT)
            sink.close(CloseCode.SILENT, "nothing was heard from this page for too long")
        elif self.presence.absent_s() > self.abandon_after_s:
            self._chronicle.note("abandoned")
            self._finish("timed_out", "abandoned")

    def _note_discarded(self) -> None:
        self._chronicle.note_client("input_discarded", {"frames": self._inbox.discarded})
        self._inbox.discarded = 0
