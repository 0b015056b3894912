"""What a run has gathered over all its trials, and what of it is not stored yet.

Importing this module loads numba; the server does so after it answers.
"""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import Callable, Iterable
from typing import TypeVar

from server.desks.learned_policies import describe_version
from server.live.learning.ports import OpenRun
from server.live.learning.rows import LearningRows, RunVersion
from study.errors import JournalError
from study.learning.agreement import Agreement, Setting
from study.learning.curve import Curve
from study.learning.dataset import Dataset, Pair
from study.learning.policy import initial_policy
from study.learning.policy_up import Version
from study.learning.session import LearningSession
from study.people.parameters import parameter_version

T = TypeVar("T")
SLICE = 500


async def in_slices(entries: Iterable[T], take: Callable[[T], None]) -> None:
    """Take all entries, and let other trials tick in between."""
    for number, entry in enumerate(entries, 1):
        take(entry)
        if number % SLICE == 0:
            await asyncio.sleep(0)


class RunRecord:
    """The run's versions, curve and agreement; and what waits for the next commit.

    `stored_iterations`: as many are closed with all their pairs stored. Make one with `gather`.
    """

    def __init__(self, opened: OpenRun) -> None:
        self.setup = opened.setup
        settings = self.setup.settings
        self.versions: list[RunVersion] = []
        self.curve = Curve(settings.iterations)
        self.agreement = Agreement(self.setup.spec.robots)
        self.stored_iterations = 0
        self._hashes: dict[int, str] = {}
        self._pairs = 0
        self._ratings = 0
        self._rated: Counter[int] = Counter()
        self._new_pairs: list[tuple[int, Pair]] = []
        self._new_versions: list[RunVersion] = []
        self._new_ratings: list[tuple[int, Setting]] = []
        if opened.versions:
            self.versions += opened.versions
        else:
            self.add_version(RunVersion(0, initial_policy(settings.thresholds)))
        if [version.iteration for version in self.versions] != list(range(len(self.versions))):
            raise JournalError(
                "the versions of its policy are not complete",
                where=f"learning run {self.setup.run_id[:6]}",
                next_step="Restore this learning run from a backup.",
            )

    @classmethod
    async def gather(cls, opened: OpenRun) -> RunRecord:
        """The record of all that is stored. Errors: JournalError when a part is missing."""
        record = cls(opened)
        await in_slices(opened.pairs, record.curve.add)
        await in_slices(opened.ratings, record.agreement.add)
        record._pairs, record._ratings = len(opened.pairs), len(opened.ratings)
        record._rated.update(rating.trial for rating in opened.ratings)
        record.stored_iterations = max((pair.iteration for pair in opened.pairs), default=0)
        return record

    # ---- what came --------------------------------------------------------------------------

    def catch_up(self, session: LearningSession) -> None:
        """Take from a re-simulated trial what is not stored yet."""
        if len(session.up.dataset) == self._pairs:
            self.stored_iterations = session.up.j
        self.add_pairs(session.take_pairs())
        self.add_settings(session.take_settings()[self._rated[session.up.trial] :])

    def add_pairs(self, pairs: Iterable[tuple[int, Pair]]) -> None:
        """Pairs with their numbers; those that are stored already are left out."""
        for number, pair in pairs:
            if number >= self._pairs:
                self.curve.add(pair)
                self._new_pairs.append((number, pair))
                self._pairs = number + 1

    def add_settings(self, settings: Iterable[Setting]) -> None:
        """What experts without the lead had set at a snapshot."""
        for setting in settings:
            self.agreement.add(setting)
            self._new_ratings.append((self._ratings, setting))
            self._ratings += 1

    def add_version(self, version: RunVersion) -> None:
        """A policy decides from now on."""
        self.versions.append(version)
        self._new_versions.append(version)

    def describe(self, version: Version) -> RunVersion:
        """A trained version as a policy file; all pairs it was trained on must have been added."""
        setup = self.setup
        people: dict[str, object] = {
            "scale": setup.scale,
            "hall": setup.spec.to_json(),
            "expert": "person",
            "worker": setup.worker,
            "run_id": setup.run_id,
        }
        if setup.worker == "simulated":
            people["people_version"] = parameter_version()
        policy = describe_version(
            version,
            setup.settings,
            self.curve.lines["policy"],
            "people",
            f"people-{setup.run_id[:6]}",
            people,
        )
        return RunVersion(version.iterations, policy)

    def hash_of(self, iteration: int) -> str:
        """The hash of a version's policy file."""
        if iteration not in self._hashes:
            self._hashes[iteration] = self.versions[iteration].policy.sha256
        return self._hashes[iteration]

    # ---- storing ----------------------------------------------------------------------------

    def take_rows(self, iteration: int, *, finished: bool) -> LearningRows | None:
        """What is not stored yet, once; None when there is nothing."""
        if not (self._new_pairs or self._new_versions or self._new_ratings):
            return None
        rows = LearningRows(
            run_id=self.setup.run_id,
            pairs=tuple(self._new_pairs),
            versions=tuple(self._new_versions),
            ratings=tuple(self._new_ratings),
            iteration=iteration,
            finished=finished,
        )
        self._new_pairs, self._new_versions, self._new_ratings = [], [], []
        return rows

    def check_pairs(self, again: Dataset, stored: tuple[Pair, ...]) -> None:
        """Hold a re-simulated dataset against the stored one. Errors: JournalError."""
        if tuple(again.pairs[: len(stored)]) != stored:
            raise JournalError(
                "the pairs of the re-simulated trial differ from the stored ones",
                where=f"learning run {self.setup.run_id[:6]}",
                next_step="Go on with the version of the software that began the trial.",
            )


def as_version(stored: RunVersion) -> Version:
    """A stored version as the learning session knows it."""
    policy = stored.policy
    data_sha256 = Dataset().sha256() if policy.training is None else policy.training["data_sha256"]
    return Version(stored.iteration, (policy.robot_table, policy.station_table), data_sha256)
