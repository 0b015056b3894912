"""Opening a trial: a fresh world, or the stored one re-simulated to its last committed tick.

Importing this module loads numba; the server does so after it answers.
"""

from __future__ import annotations

import asyncio

from server.live.chronicle import Chronicle
from server.live.clock import Clock
from server.live.inbox import Inbox
from server.live.lock_step import BOT, LockStepRoom
from server.live.ports import OpenTrial
from server.live.room import Room
from study.ar.conditions import build_condition
from study.ar.display import DisplayClock
from study.records.journal import JournalRecorder, replay
from study.warehouse.layout import build_layout
from study.warehouse.world import World

TICKS_PER_SLICE = 60


async def open_room(opened: OpenTrial, clock: Clock) -> Room:
    """The room of a trial, ready for its participant; gives way to other trials as it replays.

    A simulated participant's goes in lock-step.

    Raises JournalError if the stored inputs do not give the recorded states.
    """
    setup = opened.setup
    world = World(build_layout(setup.spec), setup.seed)
    condition = build_condition(setup.condition, setup.policy)
    display = DisplayClock(condition, len(world.robot_x_m), len(world.layout.stations))
    display.start(world)
    for stepped in replay(world, opened.journal):
        display.update(stepped)
        if stepped.tick % TICKS_PER_SLICE == 0:
            await asyncio.sleep(0)
    last_seq = opened.journal[-1].last_seq if opened.journal else 0
    consumed = sum((len(chunk.inputs) - chunk.ticks) // 3 for chunk in opened.journal)
    number = max((event.number for event in opened.events), default=-1) + 1
    recorder = JournalRecorder(world.tick + 1, last_seq)
    chronicle = Chronicle(setup.trial_id, world, clock, recorder, number)
    chronicle.recall(opened.journal, opened.events)
    chronicle.note("opened", {"resumed": world.tick > 0})
    if world.tick == 0:
        chronicle.add_display(display.display)
    kind = LockStepRoom if setup.mode == BOT else Room
    room = kind(setup, world, display, chronicle, Inbox(last_seq, consumed), clock)
    if opened.events:
        absent_s = (clock.utc() - opened.events[-1].at_utc).total_seconds()
        was_abandoned = any(event.kind == "abandoned" for event in opened.events)
        room.resume(max(0.0, absent_s), was_abandoned)
    return room
