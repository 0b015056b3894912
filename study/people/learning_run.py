"""A whole learning run with simulated people: trials one after another until PolicyUp is done."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from study.ar.display import DECISION_EVERY_TICKS, DisplayClock
from study.ar.elements import Display
from study.errors import InvalidValue
from study.learning.boxes import Checkboxes
from study.learning.policy_up import PolicyUp, stream_seed
from study.learning.settings import LearningSettings
from study.people.habits import Habits
from study.people.person import Person
from study.people.table_expert import TableExpert
from study.people.workers import Worker, check_worker, new_worker
from study.warehouse.layout import Layout
from study.warehouse.world import World


class Expert(Protocol):
    """Somebody who sets the boxes."""

    def act(self, world: World, display: Display, boxes: Checkboxes, tick: int) -> None:
        """Watch after each step of the world, and set boxes; `tick` counts over the run."""
        ...

    def answer(self, boxes: Checkboxes, states: Sequence[int]) -> None:
        """Answer the agents' states at once; who cannot know them does nothing here."""
        ...


EXPERTS = ("person", "table")


def check_people(worker: str, expert: str) -> None:
    """Raise InvalidValue for an unknown worker or expert, naming those that exist."""
    check_worker(worker)
    if expert not in EXPERTS:
        raise InvalidValue(
            f"there is no expert “{expert[:40]}”", next_step=f"Use one of: {', '.join(EXPERTS)}."
        )


def new_expert(name: str, seed: int, habits: Habits | None = None, *, confirms: bool) -> Expert:
    """Return the expert of this name for one run.

    `confirms`: says of agents that are right as they are that they are, where that is asked for.
    """
    if name == "table":
        return TableExpert()
    return Person(seed, habits or Habits(), confirms=confirms)


def run_learning(
    settings: LearningSettings,
    layout: Layout,
    worker: str,
    expert: str,
    tell: Callable[[PolicyUp], None] | None = None,
    habits: Habits | None = None,
) -> PolicyUp:
    """Run trials until all iterations are done; the same arguments give the same bits.

    Trial n runs with a seed made of the run's seed and n. `tell` is called once a simulated second.
    `habits`: of worker and expert, the defaults where there are none.
    Errors: InvalidValue for an unknown worker, expert or classifier, or a trial
    without any label.
    """
    check_people(worker, expert)
    confirms = settings.label_source == "confirmed"
    judge = new_expert(expert, stream_seed(settings.seed, "expert"), habits, confirms=confirms)
    up = PolicyUp(settings, layout.spec.robots, len(layout.stations))
    while not up.finished:
        labels = len(up.dataset)
        seed = stream_seed(settings.seed, "trial", up.trial + 1)
        world = World(layout, seed)
        walker = new_worker(worker, world, stream_seed(seed, "worker"), habits)
        _run_trial(up, world, walker, judge, tell)
        if len(up.dataset) == labels:
            raise InvalidValue(
                f"the expert “{expert}” gave no label in a whole trial",
                where="label_source",
                next_step="Use the boxes as the source of labels.",
            )
    return up


def _run_trial(
    up: PolicyUp,
    world: World,
    walker: Worker,
    judge: Expert,
    tell: Callable[[PolicyUp], None] | None,
) -> None:
    """Run one trial to its end, or until the run is done."""
    layout = world.layout
    up.begin_trial(world.seed)
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
