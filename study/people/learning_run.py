"""A whole learning run with simulated people: trials one after another until PolicyUp is done."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Protocol

from study.ar.display import DECISION_EVERY_TICKS, DisplayClock
from study.ar.elements import Display
from study.ar.situation import ObservedWorld
from study.errors import InvalidValue
from study.learning.boxes import Checkboxes
from study.learning.policy_up import PolicyUp, stream_seed
from study.learning.settings import LearningSettings
from study.people.patrols import PATROLS, Patrol
from study.people.table_expert import TableExpert
from study.people.worker import BELIEVER, Believer
from study.warehouse.layout import Layout
from study.warehouse.world import World


class Worker(Protocol):
    """Somebody who walks, and may look at the display."""

    def next_frame(self, display: Display) -> tuple[int, int]:
        """Return keys and yaw for the coming tick."""
        ...


class Expert(Protocol):
    """Somebody who sets the boxes."""

    def act(self, world: ObservedWorld, display: Display, boxes: Checkboxes, tick: int) -> None:
        """Watch after each step of the world, and set boxes; `tick` counts over the run."""
        ...

    def answer(self, boxes: Checkboxes, states: Sequence[int]) -> None:
        """Answer the agents' states at once; who cannot know them does nothing here."""
        ...


class UnseeingWorker:
    """A worker who knows the world itself and looks at no display."""

    def __init__(self, name: str, world: World, seed: int) -> None:
        self._patrol = Patrol(name, world.floor, world.motion, seed)

    def next_frame(self, display: Display) -> tuple[int, int]:
        """Return keys and yaw, whatever is displayed."""
        del display
        return self._patrol.next_frame()


WORKERS = (*PATROLS, BELIEVER)
EXPERTS: Mapping[str, Callable[[int], Expert]] = MappingProxyType(
    {"table": lambda seed: TableExpert()}
)


def new_worker(name: str, world: World, seed: int) -> Worker:
    """Return the worker of this name for one trial."""
    return Believer(world, seed) if name == BELIEVER else UnseeingWorker(name, world, seed)


def check_people(worker: str, expert: str) -> None:
    """Raise InvalidValue for an unknown worker or expert, naming those that exist."""
    for kind, name, known in (("worker", worker, WORKERS), ("expert", expert, tuple(EXPERTS))):
        if name not in known:
            raise InvalidValue(
                f"there is no {kind} “{name[:40]}”", next_step=f"Use one of: {', '.join(known)}."
            )


def run_learning(
    settings: LearningSettings,
    layout: Layout,
    worker: str,
    expert: str,
    tell: Callable[[PolicyUp], None] | None = None,
) -> PolicyUp:
    """Run trials until all iterations are done; the same arguments give the same bits.

    Trial n runs with a seed made of the run's seed and n. `tell` is called once a simulated second.
    Errors: InvalidValue for an unknown worker, expert or classifier, or a trial
    without any label.
    """
    check_people(worker, expert)
    up = PolicyUp(settings, layout.spec.robots, len(layout.stations))
    judge = EXPERTS[expert](stream_seed(settings.seed, "expert"))
    while not up.finished:
        labels = len(up.dataset)
        _run_trial(up, layout, worker, judge, tell)
        if len(up.dataset) == labels:
            raise InvalidValue(
                f"the expert “{expert}” gave no label in a whole trial",
                where="label_source",
                next_step="Use the boxes as the source of labels.",
            )
    return up


def _run_trial(
    up: PolicyUp,
    layout: Layout,
    worker: str,
    judge: Expert,
    tell: Callable[[PolicyUp], None] | None,
) -> None:
    """Run one trial to its end, or until the run is done."""
    seed = stream_seed(up.settings.seed, "trial", up.trial + 1)
    world = World(layout, seed)
    walker = new_worker(worker, world, stream_seed(seed, "worker"))
    up.begin_trial(seed)
    clock = DisplayClock(up, layout.spec.robots, len(layout.stations))
    judge.act(world, clock.display, up.boxes, up.run_tick(0))
    up.attend(world, clock.display, judge.answer)
    clock.start(world)
    while world.status == "running" and not up.finished:
        world.step([walker.next_frame(clock.display)])
        judge.act(world, clock.display, up.boxes, up.run_tick(world.tick))
        if world.tick % DECISION_EVERY_TICKS == 0:
            up.attend(world, clock.display, judge.answer)
            clock.update(world)
            if tell is not None:
                tell(up)
