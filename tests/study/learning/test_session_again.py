"""Guards that a learning session run again from its entries equals the live one to the bit."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from study.errors import InvalidValue, WrongMoment
from study.learning.dataset import Dataset, Pair
from study.learning.policy_up import Version
from study.learning.session import Entry, LearningSession, begin_session
from study.learning.settings import LearningSettings
from tests.study.learning.moments import AGENTS, busy_moment

ANNA, BEN, CLEO = "a" * 16, "b" * 16, "c" * 16
NAMES = {ANNA: "anna", BEN: "ben", CLEO: "cleo"}

pages = st.sampled_from(sorted(NAMES))
changes = st.lists(
    st.tuples(st.integers(0, 9), st.integers(0, 7), st.integers(0, 7)), min_size=1, max_size=3
)
actions = st.one_of(
    st.tuples(st.just("join"), pages),
    st.tuples(st.just("leave"), pages),
    st.tuples(st.just("take_lead"), pages),
    st.tuples(st.just("hand_over"), pages, pages),
    st.tuples(st.just("edit"), pages, changes),
    st.tuples(st.just("confirm"), pages, st.lists(st.integers(0, 9), max_size=3)),
    st.tuples(st.just("train")),
)
scripts = st.dictionaries(st.integers(0, 39), st.lists(actions, min_size=1, max_size=5))


@dataclass
class Told:
    """Everything that a session did, to be compared."""

    pairs: list[tuple[int, Pair]] = field(default_factory=list)
    settings: list[Any] = field(default_factory=list)
    displays: list[Any] = field(default_factory=list)
    rules: list[list[bool]] = field(default_factory=list)

    def note(self, session: LearningSession) -> None:
        self.pairs += session.take_pairs()
        self.settings += session.take_settings()
        self.displays.append(session.display)
        self.rules.append(session.up.by_expert.tolist())


def train(session: LearningSession) -> Version:
    """A policy that can be told from all others."""
    n = session.up.versions[-1].iterations + 1
    robots = tuple((n * 3 + state) % 8 for state in range(144))
    return Version(n, (robots, tuple((n + state) % 2 for state in range(18))), f"data-{n}")


def act_live(session: LearningSession, action: tuple[Any, ...], seq: int) -> tuple[Entry, ...]:
    name, *words = action
    try:
        if name == "join":
            return session.join(NAMES[words[0]], words[0])
        if name in ("edit", "confirm"):
            if words[0] not in session.panel.present:
                return ()
            return getattr(session, name)(words[0], seq, words[1])  # type: ignore[no-any-return]
        if name == "take_lead" and words[0] not in session.panel.present:
            return ()
        if name == "train":
            if session.owed_orders():
                version = train(session)
                session.offer(version, f"sha-{version.iterations}")
            return ()
        return getattr(session, name)(*words)  # type: ignore[no-any-return]
    except (InvalidValue, WrongMoment):
        return ()


def play_live(session: LearningSession, script: dict[int, Any]) -> tuple[Told, list[Any]]:
    """Decisions every second of world time, with what experts did in between."""
    told, journal, seq = Told(), [], 0
    session.start(busy_moment(0))
    for step in range(40):
        tick = 30 * step
        if step:
            session.update(busy_moment(tick))
        journal += [(tick, *entry) for entry in session.take_entries()]
        for action in script.get(step, ()):
            seq += 1
            journal += [(tick, *entry) for entry in act_live(session, action, seq)]
        told.note(session)
    return told, journal


def play_again(session: LearningSession, journal: list[Any]) -> Told:
    told = Told()
    for step in range(40):
        tick = 30 * step
        entries = [entry[1:] for entry in journal if entry[0] == tick]
        for kind, data in entries:
            if kind == "policy_replaced":
                n = int(data["policy_sha256"].removeprefix("sha-"))
                session.offer(train_number(session, n), data["policy_sha256"])
        if step:
            session.update(busy_moment(tick))
        else:
            session.start(busy_moment(0))
        for kind, data in entries:
            if kind != "policy_replaced":
                session.apply(kind, data)
        told.note(session)
    return told


def train_number(session: LearningSession, n: int) -> Version:
    assert n == session.up.versions[-1].iterations + 1
    return train(session)


def reopen(session: LearningSession) -> LearningSession:
    """What a restarted server makes of the state at a trial's start."""
    record = json.loads(json.dumps(session.to_json()))
    up = session.up
    return LearningSession.from_json(
        record, up.settings, AGENTS, Dataset(up.dataset), list(up.versions)
    )


@given(scripts, scripts, st.sampled_from(["follow", "independent"]))
def test_a_session_run_again_equals_the_live_one(
    first: dict[int, Any], second: dict[int, Any], box_mode: str
) -> None:
    """Two trials; the second starts from stored state and is run again from its entries.

    Pairs, settings of others, displays, decision rules and the final state are the same bits.
    """
    settings = LearningSettings(iterations=12, beta="exponential(0.7)", box_mode=box_mode)
    session = begin_session(settings, AGENTS)
    session.up.begin_trial(5)
    first = {0: [("join", ANNA), *first.get(0, ())], **{k: v for k, v in first.items() if k}}
    play_live(session, first)
    session.up.begin_trial(6)
    live, again = reopen(session), reopen(session)
    told, journal = play_live(live, second)
    assert play_again(again, journal) == told
    assert again.to_json() == live.to_json()
    assert len(told.pairs) == len(live.up.dataset) - len(session.up.dataset)
