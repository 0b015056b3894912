"""Opening a learning run: its trial is re-simulated with its inputs and the experts' entries.

Importing this module loads numba; the server does so after it answers.
"""

from __future__ import annotations

import asyncio
import uuid
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from server.live.chronicle import Chronicle
from server.live.clock import Clock
from server.live.inbox import Inbox
from server.live.learning.ports import OpenRun, RunSetup
from server.live.learning.record import RunRecord, as_version, in_slices
from server.live.learning.room import LearningRoom
from server.live.learning.simulated_worker import SimulatedWorker
from server.live.opening import TICKS_PER_SLICE
from server.live.ports import OpenTrial, TrialSetup
from study.errors import JournalError
from study.learning.dataset import Dataset
from study.learning.policy_up import stream_seed
from study.learning.session import LearningSession, begin_session
from study.records.events import JournalEvent
from study.records.journal import JournalRecorder, replay
from study.warehouse.layout import Layout, build_layout
from study.warehouse.world import World

EXPERT_EVENTS = (
    "expert_joined", "expert_left", "lead_changed", "expert_set", "expert_confirmed",
)  # fmt: skip
YEAR_S = 365 * 86400.0


@dataclass(frozen=True)
class Scene:
    """A trial's world with its session and, if nobody else works in it, its simulated worker."""

    world: World
    session: LearningSession
    hands: SimulatedWorker | None


@dataclass(frozen=True)
class NextTrial:
    """A trial of a run before it begins, and the run's state at its start."""

    number: int
    setup: TrialSetup
    start: Mapping[str, Any]


def hall_of(setup: RunSetup) -> Layout:
    """The hall of all the run's trials."""
    return build_layout(setup.spec)


def first_session(setup: RunSetup) -> LearningSession:
    """The run before its first trial."""
    return begin_session(setup.settings, (setup.spec.robots, len(hall_of(setup).stations)))


def plan_trial(setup: RunSetup, session: LearningSession, time_scale: float) -> NextTrial:
    """The trial after that of `session`, which is over; a run waits for its people a year."""
    up = session.up
    number = up.trial + 1
    up.begin_trial(stream_seed(setup.settings.seed, "trial", number))
    trial = TrialSetup(
        trial_id=uuid.uuid4().hex,
        kind="learning",
        scale=setup.scale,
        spec=setup.spec,
        seed=up.trial_seed,
        condition="learning",
        policy=None,
        label=f"Round {number + 1}",
        mode="learning",
        time_scale=time_scale,
        abandon_after_s=YEAR_S,
        number=number,
    )
    return NextTrial(number, trial, session.to_json())


def begin_scene(setup: RunSetup, planned: NextTrial, former: LearningSession) -> Scene:
    """The planned trial at tick 0, before its first decision."""
    world = World(hall_of(setup), planned.setup.seed)
    up = former.up
    agents = (up.robots, up.agents - up.robots)
    session = LearningSession.from_json(
        planned.start, up.settings, agents, up.dataset, list(up.versions)
    )
    return Scene(world, session, _hands(setup, world, OpenTrial(planned.setup)))


async def run_again(opened: OpenRun, trial: OpenTrial, record: RunRecord) -> Scene:
    """The stored trial at its last committed tick; gives way to other trials as it goes.

    Errors: JournalError if inputs, entries, pairs or versions do not fit together.
    """
    setup, start = opened.setup, opened.start
    if start is None:
        raise JournalError(
            "the run's state at its start is missing",
            where=f"trial {trial.setup.trial_id}",
            next_step="Restore this learning run from a backup.",
        )
    world = World(hall_of(setup), trial.setup.seed)
    dataset = Dataset()
    number = int(start["up"]["trial"])
    await in_slices((pair for pair in opened.pairs if pair.trial < number), dataset.add)
    versions = [as_version(version) for version in record.versions[: start["up"]["versions"]]]
    agents = (setup.spec.robots, len(world.layout.stations))
    session = LearningSession.from_json(start, setup.settings, agents, dataset, versions)
    scene = Scene(world, session, _hands(setup, world, trial))
    await _replay(scene, trial, record)
    record.check_pairs(dataset, opened.pairs)
    return scene


def open_room(trial: OpenTrial, scene: Scene, clock: Clock) -> LearningRoom:
    """The room of a trial at the tick of its scene."""
    setup = replace(trial.setup, number=scene.session.up.trial)
    world, journal = scene.world, trial.journal
    last_seq = journal[-1].last_seq if journal else 0
    consumed = sum((len(chunk.inputs) - chunk.ticks) // 3 for chunk in journal)
    number = max((event.number for event in trial.events), default=-1) + 1
    recorder = JournalRecorder(world.tick + 1, last_seq)
    chronicle = Chronicle(setup.trial_id, world, clock, recorder, number)
    chronicle.recall(journal, trial.events)
    chronicle.note("opened", {"resumed": world.tick > 0})
    if world.tick == 0:
        chronicle.add_display(scene.session.display)
    return LearningRoom(setup, world, scene.session, chronicle, Inbox(last_seq, consumed), clock)


def _hands(setup: RunSetup, world: World, trial: OpenTrial) -> SimulatedWorker | None:
    if setup.worker != "simulated":
        return None
    last_seq = trial.journal[-1].last_seq if trial.journal else 0
    return SimulatedWorker(world, trial.setup.seed, last_seq)


async def _replay(scene: Scene, trial: OpenTrial, record: RunRecord) -> None:
    world, session = scene.world, scene.session
    moments: dict[int, list[JournalEvent]] = defaultdict(list)
    for event in sorted(trial.events, key=lambda event: event.number):
        moments[event.tick].append(event)
    _offer(session, moments[0], record)
    session.start(world)
    _apply(session, moments[0])
    steps = replay(world, trial.journal)
    for _ in range(sum(chunk.ticks for chunk in trial.journal)):
        if scene.hands is not None:
            scene.hands.next_frame(session.display)
        next(steps)
        entries = moments.get(world.tick, [])
        _offer(session, entries, record)
        session.update(world)
        _apply(session, entries)
        if world.tick % TICKS_PER_SLICE == 0:
            await asyncio.sleep(0)
    next(steps, None)
    session.take_entries()


def _offer(session: LearningSession, entries: list[JournalEvent], record: RunRecord) -> None:
    """The policies that were replaced at this tick, in order."""
    known = session.up.versions[-1].iterations
    for number, event in enumerate((e for e in entries if e.kind == "policy_replaced"), known + 1):
        policy_sha256 = str(event.data["policy_sha256"])
        if number >= len(record.versions) or record.hash_of(number) != policy_sha256:
            raise JournalError(
                f"the policy {policy_sha256[:12]} is not version {number} of the run",
                where=f"tick {event.tick}",
                next_step="Restore this learning run from a backup.",
            )
        session.offer(as_version(record.versions[number]), policy_sha256)


def _apply(session: LearningSession, entries: list[JournalEvent]) -> None:
    for event in entries:
        if event.kind in EXPERT_EVENTS:
            session.apply(event.kind, event.data)
