"""A stored trial shown again: re-simulated from its journal, at any speed, from any moment.

The page is sent the same messages as that of a running trial. A stored state that the simulation
does not reach again ends the replay with the tick at which they part.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

from server.live import wire
from server.live.audience import Audience
from server.live.outbox import Outbox, SpectatorOutbox
from server.live.ports import OpenTrial
from server.live.watching import StaffTalk, Who
from server.live.wire import CloseCode, WireError

if TYPE_CHECKING:
    from study.ar.display import DisplayClock
    from study.warehouse.world import World

SPEEDS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0)
FRAME_TICKS = wire.TICK_HZ // wire.SNAPSHOT_HZ
FRAME_S = FRAME_TICKS / wire.TICK_HZ
TICKS_PER_SLICE = 60

ReadTrial = Callable[[str], Awaitable[OpenTrial]]


class ReplayTalk(StaffTalk):
    """Plays, pauses, hurries and seeks as its page says."""

    def __init__(self, outbox: SpectatorOutbox, who: Who, trial_id: str, read: ReadTrial) -> None:
        super().__init__(outbox, who)
        self._trial_id = trial_id
        self._read = read
        self._is_playing = False
        self._speed = 1.0
        self._seek: int | None = None
        self._told = asyncio.Event()

    def act(self, name: str, record: Mapping[str, Any]) -> None:
        """Play, pause, speed or seek."""
        if name in ("play", "pause"):
            self._is_playing = name == "play"
        elif name == "speed":
            speed = wire.read_field("speed", record, "times", float)
            if speed not in SPEEDS:
                raise WireError(f"a speed of {', '.join(f'{s:g}' for s in SPEEDS)}", str(speed))
            self._speed = speed
        elif name == "seek":
            self._seek = max(0, int(wire.read_field("seek", record, "tick", int)))
        else:
            raise WireError("play, pause, speed or seek", name)
        self._told.set()

    async def begin(self) -> None:
        """Load the trial and play it until the page goes."""
        opened = await self._read(self._trial_id)
        if not opened.journal:
            self.turn_away(
                CloseCode.NO_TRIAL, "nothing was played in this trial: it has no journal"
            )
            return
        self._last = opened.journal[-1].last_tick
        film = _Film(opened)
        self._show(film)
        while True:
            if self._seek is not None:
                film = await self._go_to(film, opened)
            elif self._is_playing and film.tick < self._last:
                await self._play(film)
            else:
                await self._rest(film)

    async def _play(self, film: _Film) -> None:
        clock = asyncio.get_running_loop().time
        due_s = clock() + FRAME_S
        film.credit += self._speed * FRAME_TICKS
        while film.credit >= 1.0 and film.tick < self._last:
            film.credit -= 1.0
            film.step()
        film.send()
        if film.tick >= self._last:
            self._is_playing = False
        await asyncio.sleep(max(0.0, due_s - clock()))

    async def _rest(self, film: _Film) -> None:
        self._told.clear()
        film.tell_phase("finished" if film.tick >= self._last else "paused")
        film.send()
        await self._told.wait()
        if self._is_playing and film.tick >= self._last and self._seek is None:
            self._seek = 0
        if self._is_playing:
            film.tell_phase("running")

    async def _go_to(self, film: _Film, opened: OpenTrial) -> _Film:
        """The film at the tick asked for: backwards it begins anew."""
        wanted, self._seek = min(self._seek or 0, self._last), None
        if wanted < film.tick:
            film = _Film(opened)
        while film.tick < wanted and self._seek is None:
            for _ in range(min(TICKS_PER_SLICE, wanted - film.tick)):
                film.step()
            await asyncio.sleep(0)
        self._show(film)
        return film

    def _show(self, film: _Film) -> None:
        self.outbox.send_text(wire.encode_text({"type": "length", "ticks": self._last}))
        film.show(self.outbox)


class _Film:
    """The trial's world and display at one moment of its journal."""

    def __init__(self, opened: OpenTrial) -> None:
        from study.ar.conditions import build_condition  # loads numba
        from study.ar.display import DisplayClock
        from study.records.journal import replay
        from study.warehouse.layout import build_layout
        from study.warehouse.world import World

        setup = opened.setup
        self.credit = 0.0
        self._world: World = World(build_layout(setup.spec), setup.seed)
        condition = build_condition(setup.condition, setup.policy)
        world = self._world
        self._display: DisplayClock = DisplayClock(
            condition, len(world.robot_x_m), len(world.layout.stations)
        )
        self._display.start(world)
        self._steps: Iterator[object] = iter(replay(world, opened.journal))
        self._audience = Audience(setup, world)
        self._audience.show(self._display.display)
        self._boxes = 0

    @property
    def tick(self) -> int:
        """The present tick."""
        return self._world.tick

    def show(self, outbox: Outbox) -> None:
        """Let the page see this film from now on; it forgets what it saw before."""
        self._boxes = int(self._world.boxes_delivered)
        self._audience.remove(outbox)
        self._audience.add(outbox, 0)

    def step(self) -> None:
        """One tick on. Raises JournalError where the recorded state is not reached again."""
        next(self._steps, None)
        display = self._display.update(self._world)
        if display is not None:
            self._audience.show(display)

    def send(self) -> None:
        """What is seen now."""
        boxes = int(self._world.boxes_delivered)
        if boxes != self._boxes:
            self._boxes = boxes
            self._audience.tell(wire.encode_delivered(boxes))
        self._audience.send_snapshot(0)

    def tell_phase(self, phase: wire.PhaseName) -> None:
        """Whether it plays."""
        reason: wire.PhaseReason = "completed" if phase == "finished" else "start"
        self._audience.tell(wire.encode_phase(phase, self.tick, reason, 0))
