"""Guards restarts: what is opened again from the desk is the run that was lost, to the bit."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from server.live.learning.telling import tell_agreement
from study.errors import JournalError
from tests.server.live.learning.lab import (
    ANNA,
    BEN,
    RUN,
    SETTINGS,
    SETUP,
    Lab,
    MemoryLearningDesk,
    settle,
)

TRIALS = 3
LONGEST_S = 900


def new_lab(**settings: Any) -> Lab:
    """A run of three short trials, most of a year's worth of edits, two experts."""
    wanted = replace(SETTINGS, iterations=20, **settings)
    return Lab(MemoryLearningDesk(replace(SETUP, settings=wanted)))


def act(lab: Lab) -> None:
    """Both experts change boxes every second; what depends on trial and tick only."""
    room = lab.room
    trial, tick = room.session.up.trial, room.world.tick
    if room.result is not None or tick % 30 != 7:
        return
    draws = np.random.default_rng([trial, tick])
    for client in lab.seats:
        agent, on, off = (int(n) for n in draws.integers(0, (10, 8, 8)))
        full = 7 if agent < 6 else 1
        lab.edit(trial * 10**6 + tick, (agent, on & full, off & ~on & full), client=client)


async def come_back(lab: Lab) -> None:
    await lab.join(ANNA)
    await lab.join(BEN)


async def play_to_end(lab: Lab) -> None:
    for _ in range(LONGEST_S):
        await lab.play(1, act)
        if RUN not in lab.runs.held:
            break
    assert lab.desk.status == "finished"


def outcome(desk: MemoryLearningDesk) -> dict[str, Any]:
    """Everything that must not depend on whether a server was ever stopped."""
    results = [desk.results.get(setup.trial_id) for setup, _ in desk.trials]
    return {
        "pairs": [desk.pairs[n] for n in sorted(desk.pairs)],
        "versions": desk.versions,
        "ratings": desk.ratings,
        "starts": [text for _, text in desk.trials],
        "states": [(r.ticks, r.state_hash) for r in results if r is not None],
    }


@pytest.fixture(params=["follow", "independent"])
async def whole(request: pytest.FixtureRequest) -> tuple[str, dict[str, Any]]:
    """A run without any restart."""
    lab = new_lab(box_mode=request.param)
    await come_back(lab)
    await play_to_end(lab)
    assert len(lab.desk.trials) >= TRIALS
    assert lab.desk.ratings
    return request.param, outcome(lab.desk)


@pytest.mark.parametrize("crashes", [(20,), (5, 6, 47, 101, 103, 160)])
async def test_a_run_that_was_killed_goes_on_to_the_same_end(
    whole: tuple[str, dict[str, Any]], crashes: tuple[int, ...]
) -> None:
    """Two seconds are lost each time; pairs, policies, ratings and worlds come out the same."""
    box_mode, wanted = whole
    lab = new_lab(box_mode=box_mode)
    await come_back(lab)
    for first, last in zip((0, *crashes), crashes, strict=False):
        await lab.play(last - first, act)
        kept = state(lab)
        await lab.play(2, act, store=False)
        lab.crash()
        await come_back(lab)
        assert state(lab) == kept
    await play_to_end(lab)
    found = outcome(lab.desk)
    assert found.keys() == wanted.keys()
    for name, value in wanted.items():
        assert found[name] == value, name


def state(lab: Lab) -> dict[str, Any]:
    """D, j, the policy, the boxes and the display, as far as the last commit knows them."""
    session = lab.room.session
    return {
        "run": session.to_json(),
        "data": session.up.dataset.sha256(),
        "tables": session.up.latest,
        "display": session.display,
        "tick": lab.room.world.tick,
        "world": lab.room.world.state_hash(),
        "curve": lab.run.record.curve.to_json(0, 20),
        "agreement": tell_agreement(lab.run.record),
        "stored": lab.run.record.stored_iterations,
    }


async def test_a_run_killed_between_two_trials_begins_the_next_as_it_would_have(
    whole: tuple[str, dict[str, Any]], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first trial's end is stored, the second's beginning is not."""
    box_mode, wanted = whole
    lab = new_lab(box_mode=box_mode)
    await come_back(lab)

    async def stay_away(*words: Any) -> None:
        raise ConnectionError

    with monkeypatch.context() as patch:
        patch.setattr(lab.desk, "begin_trial", stay_away)
        while not lab.desk.results:
            await lab.play(1, act)
        await settle()
    assert len(lab.desk.trials) == 1
    lab.crash()
    await come_back(lab)
    assert len(lab.desk.trials) == 2
    await play_to_end(lab)
    assert outcome(lab.desk) == wanted


async def test_a_training_that_was_lost_is_ordered_again() -> None:
    """The process dies with the server; the order is made anew from the pairs."""
    lab = new_lab()
    await come_back(lab)
    lab.trainer.gate.clear()
    await lab.play(30, act)
    assert lab.trainer.orders == [1, 2]
    lab.crash()
    await come_back(lab)
    assert lab.trainer.orders == [1, 2, 1, 2]
    lab.trainer.gate.set()
    await lab.play(6, act)
    assert sorted(lab.desk.versions)[:3] == [0, 1, 2]


async def test_the_last_training_may_come_after_the_last_trial() -> None:
    """The run then ends with a trial of no tick, and nothing of it is lost by a restart."""
    lab = Lab(MemoryLearningDesk(replace(SETUP, settings=replace(SETTINGS, iterations=3))))
    await come_back(lab)
    lab.trainer.gate.clear()
    while not lab.desk.results:
        await lab.play(1, act)
    assert lab.desk.status == "open"
    lab.crash()
    lab.trainer.gate.set()
    await come_back(lab)
    await lab.play(3)
    assert lab.desk.status == "finished"
    assert sorted(lab.desk.versions) == [0, 1, 2, 3]
    assert [lab.desk.results[s.trial_id].ticks > 0 for s, _ in lab.desk.trials] == [True, False]
    assert lab.texts("ended")[-1]["status"] == "finished"


async def test_stored_pairs_that_differ_are_noticed() -> None:
    """Other software, or a changed row: the run does not go on with what it cannot repeat."""
    lab = new_lab()
    await come_back(lab)
    await lab.play(30, act)
    lab.crash()
    lab.desk.pairs[4] = lab.desk.pairs[4]._replace(state=lab.desk.pairs[4].state ^ 1)
    with pytest.raises(JournalError, match="differ from the stored ones"):
        await lab.join()


async def test_a_policy_of_another_run_is_noticed() -> None:
    lab = new_lab()
    await come_back(lab)
    await lab.play(40, act)
    lab.crash()
    lab.desk.versions[1] = lab.desk.versions[2]
    with pytest.raises(JournalError, match="is not version 1 of the run"):
        await lab.join()
