"""PolicyUp, the paper's Algorithm 2: a policy learned from an expert while people work (DAgger).

Symbols as in the paper: agents A, iterations j = 0 .. J - 1, dataset D, expert policy pi*, novice
policy pi_j, beta_j. The order within a tick is: agent states, pairs, closing an iteration, then
the decision what is displayed. Training stands outside, so that a server can do it elsewhere.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from study.ar.drawn import drawn_elements
from study.ar.elements import Display
from study.ar.situation import ObservedWorld
from study.ar.states import robot_states, station_states
from study.errors import JournalError
from study.learning.boxes import Checkboxes
from study.learning.classifiers import choose_classifier
from study.learning.dataset import Dataset, Pair
from study.learning.settings import (
    PAIRS_PER_ITERATION,
    RECENT_TICKS,
    SNAPSHOT_TICKS,
    LearningSettings,
)
from study.learning.training import (
    Tables,
    Trainer,
    TrainingOrder,
    initial_tables,
    train_tables,
)
from study.warehouse.state import RobotState
from study.warehouse.tasks import Draws

_COUNTERS = ("j", "units", "trial", "trial_seed", "ticks_before")
Answer = Callable[[Checkboxes, Sequence[int]], None]
"""Lets an expert without delay answer the states of all agents by setting boxes."""


@dataclass(frozen=True)
class Version:
    """The policy after so many iterations, and the hash of the data it was trained on."""

    iterations: int
    tables: Tables
    data_sha256: str


def stream_seed(seed: int, *words: object) -> int:
    """Return 63 bits that depend on the run's seed and on what they are for."""
    text = "/".join(map(str, (seed, *words)))
    return int.from_bytes(hashlib.blake2b(text.encode(), digest_size=8).digest(), "big") >> 1


class PolicyUp:
    """One learning run: D, j, the latest policy, the boxes and each agent's stream of draws.

    All of it carries over from one trial to the next. `by_expert[agent]` says whose choice is
    displayed for the agent during the present iteration. With `train` None, an iteration that
    closes leaves an order in `orders` and the next begins at once with the old policy, until
    `install` brings the new one. Pairs are taken while `is_recording`.
    """

    def __init__(
        self,
        settings: LearningSettings,
        robots: int,
        stations: int,
        train: Trainer | None = train_tables,
    ) -> None:
        choose_classifier(settings.classifier)
        self.settings = settings
        self.robots = robots
        self.agents = robots + stations
        self.train = train
        self.dataset = Dataset()
        self.boxes = Checkboxes(robots, stations, follow=settings.box_mode == "follow")
        self.versions = [Version(0, initial_tables(), self.dataset.sha256())]
        self.orders: list[TrainingOrder] = []
        self.is_recording = True
        self.j = 0
        self.units = 0
        self.trial = -1
        self.trial_seed = 0
        self.ticks_before = 0
        self.last_tick = 0
        self._states: list[int] = [0] * self.agents
        self._streams = [
            Draws(stream_seed(settings.seed, "beta", agent)) for agent in range(self.agents)
        ]
        self.by_expert = self._draw_rule()

    @property
    def latest(self) -> Tables:
        """The latest policy's tables."""
        return self.versions[-1].tables

    @property
    def finished(self) -> bool:
        """Whether all J iterations are done."""
        return self.j == self.settings.iterations

    @property
    def complete(self) -> bool:
        """Whether the last iteration's policy has come, too."""
        return self.versions[-1].iterations == self.settings.iterations

    def begin_trial(self, seed: int) -> None:
        """Go on with another trial: D, j, the policy and the boxes carry over."""
        self.ticks_before += self.last_tick
        self.last_tick = 0
        self.trial += 1
        self.trial_seed = seed

    def run_tick(self, tick: int) -> int:
        """The tick of the run at a tick of the present trial."""
        return self.ticks_before + tick

    def install(self, version: Version) -> None:
        """Let the next version decide from now on. Errors: JournalError if it is not the next."""
        if version.iterations != len(self.versions) or version.iterations > self.j:
            raise JournalError(
                f"version {version.iterations} cannot follow version {len(self.versions) - 1}",
                where=f"iteration {self.j}",
                next_step="Restore this learning run from a backup.",
            )
        self.versions.append(version)
        self.orders = [order for order in self.orders if order.iteration > version.iterations]

    def is_snapshot_due(self, tick: int) -> bool:
        """Whether pairs are taken at this tick of the trial."""
        due = tick > 0 and tick % SNAPSHOT_TICKS == 0
        return due and self.is_recording and not self.finished

    def attend(self, world: ObservedWorld, previous: Display, answer: Answer | None = None) -> None:
        """Look at the world at a decision tick, and take the pairs if a snapshot is due.

        `previous`: what has been displayed since the last decision.
        """
        thresholds = self.settings.thresholds
        self.last_tick = world.tick
        self._states = [
            *robot_states(world, previous, thresholds).tolist(),
            *station_states(world, thresholds).tolist(),
        ]
        self._propose(answer)
        if self.is_snapshot_due(world.tick):
            self._take_snapshot(world, answer)

    def decide(self, world: ObservedWorld, previous: Display) -> Display:
        """pi_j: the expert's boxes or the policy's choice for each agent, as drawn for this j."""
        del world, previous
        chosen = [
            box if expert else proposal
            for box, proposal, expert in zip(
                self.boxes.masks, self.boxes.proposals, self.by_expert, strict=True
            )
        ]
        return Display(bytes(chosen[: self.robots]), bytes(chosen[self.robots :]))

    def _propose(self, answer: Answer | None) -> None:
        robots, stations = self.latest
        states = self._states
        self.boxes.propose(
            [robots[s] for s in states[: self.robots]]
            + [stations[s] for s in states[self.robots :]]
        )
        if answer is not None:
            answer(self.boxes, states)

    def _take_snapshot(self, world: ObservedWorld, answer: Answer | None) -> None:
        """One pair per agent in fixed order; a robot at home gives none [our choice]."""
        drawn = drawn_elements(world)
        at_home = (world.robot_state == RobotState.HOME).tolist()
        by_agent = self.settings.pair_unit == "agent"
        taken = 0
        for agent in range(self.agents):
            if self.finished:
                return
            if (agent < self.robots and at_home[agent]) or not self._is_labelled(agent):
                continue
            self._record(agent, drawn[agent])
            taken += 1
            if by_agent:
                self._count_unit(answer)
        if taken and not by_agent:
            self._count_unit(answer)

    def _is_labelled(self, agent: int) -> bool:
        now = self.run_tick(self.last_tick)
        source = self.settings.label_source
        if source == "events":
            return self.boxes.was_edited(agent, now, RECENT_TICKS)
        if source == "confirmed":
            return self.boxes.was_confirmed(agent, now, RECENT_TICKS)
        return True

    def _record(self, agent: int, drawn: int) -> None:
        box, proposal = self.boxes.masks[agent], self.boxes.proposals[agent]
        station = agent >= self.robots
        self.dataset.add(
            Pair(
                iteration=self.j,
                trial=self.trial,
                trial_seed=self.trial_seed,
                tick=self.last_tick,
                domain=int(station),
                agent=agent - self.robots if station else agent,
                state=self._states[agent],
                box=box,
                proposal=proposal,
                drawn=drawn,
                label=box & drawn | proposal & ~drawn,
                edit_ticks=self.boxes.edit_age(agent, self.run_tick(self.last_tick)),
                by_expert=int(self.by_expert[agent]),
            )
        )

    def _count_unit(self, answer: Answer | None) -> None:
        """Count one of the 25 and close the iteration with the last: train, replace, draw."""
        self.units += 1
        if self.units % PAIRS_PER_ITERATION:
            return
        self.j += 1
        order = self._order(self.j, self.dataset)
        if self.train is None:
            self.orders.append(order)
        else:
            self.install(Version(order.iteration, self.train(order), order.data_sha256))
        if not self.finished:
            self.by_expert = self._draw_rule()
            self._propose(answer)

    def _order(self, iteration: int, data: Dataset) -> TrainingOrder:
        counts = tuple(counts.copy() for counts in data.counts)
        return TrainingOrder(
            iteration, counts, self.latest, self.settings.classifier, data.sha256()
        )

    def _draw_rule(self) -> npt.NDArray[np.bool_]:
        """One Bernoulli(beta_j) draw for each agent from its own stream."""
        beta = self.settings.beta_of(self.j)
        return np.array([stream.next() / 2.0**64 < beta for stream in self._streams])

    # ---- between processes ------------------------------------------------------------------

    def to_json(self) -> dict[str, Any]:
        """All that carries over besides D and the versions' tables, right after `begin_trial`."""
        return {
            **{name: getattr(self, name) for name in _COUNTERS},
            "versions": len(self.versions),
            "by_expert": self.by_expert.astype(int).tolist(),
            "streams": [stream.state for stream in self._streams],
            "boxes": self.boxes.to_json(),
        }

    def load(self, record: Mapping[str, Any], dataset: Dataset, versions: list[Version]) -> None:
        """Take over what `to_json` gave, with D and the versions of that moment.

        Orders whose policy had not come are made again. Errors: JournalError if the three do not
        belong together.
        """
        for name in _COUNTERS:
            setattr(self, name, int(record[name]))
        self.last_tick = 0
        self.dataset, self.versions = dataset, versions
        self.by_expert = np.array(record["by_expert"], dtype=np.bool_)
        self._streams = [Draws(int(state)) for state in record["streams"]]
        self.boxes.load(record["boxes"])
        begun = max((pair.iteration + 1 for pair in dataset.pairs), default=0)
        if len(versions) != record["versions"] or not self.j <= begun <= self.j + 1:
            raise JournalError(
                f"{len(versions)} versions and pairs of {begun} iterations do not fit"
                f" {record['versions']} versions and {self.j} closed iterations",
                where=f"trial {self.trial}",
                next_step="Restore this learning run from a backup.",
            )
        self.orders = [
            self._order(n, Dataset(pair for pair in dataset.pairs if pair.iteration < n))
            for n in range(len(versions), self.j + 1)
        ]
