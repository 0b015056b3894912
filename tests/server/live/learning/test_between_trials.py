"""Guards the way from one trial of a learning run to the next: who comes along, what is refused."""

from __future__ import annotations

from dataclasses import replace

import pytest

from server.live.learning import wire
from server.live.learning.experts import BETWEEN_TRIALS
from server.live.learning.room import LearningRoom
from server.live.wire import CloseCode
from study.errors import JournalError
from tests.server.live.learning.lab import ANNA, BEN, Lab, short_run


async def test_a_label_from_a_finished_trial_is_refused() -> None:
    """Between two trials, and when the next has begun; nothing of it is stored anywhere."""
    lab = Lab(short_run(80))
    await lab.start()
    for _ in range(400):
        if lab.room.result is not None:
            break
        await lab.play(1, store=False)
    late = wire.Edit(1, 0, lab.room.world.tick, ((0, 0, 1),))
    lab.run.edit(lab.seats[ANNA], late)
    await lab.play(8)
    assert lab.room.session.up.trial == 1
    lab.run.edit(lab.seats[ANNA], replace(late, seq=2))
    await lab.play(1)
    between, after = lab.texts("refused")
    assert between["message"].startswith(BETWEEN_TRIALS)
    assert "trial 1 is not the present one" in after["message"]
    assert lab.desk.kinds(0) + lab.desk.kinds(1) == [
        "expert_joined", "lead_changed", "expert_joined",
    ]  # fmt: skip
    assert lab.texts("agents")[-1]["boxes"][0] == 7
    assert lab.texts("stored") == []


async def test_who_only_looks_on_is_taken_along_into_the_next_trial() -> None:
    """Of an expert without the lead who has set nothing, the run's state knows nothing."""
    lab = Lab(short_run(80))
    await lab.start()
    page = await lab.join(BEN)
    for _ in range(400):
        if len(lab.desk.trials) > 1:
            break
        await lab.play(1)
    await lab.play(8)
    assert len(lab.desk.trials) == 2
    assert lab.room.session.up.trial == 1
    assert lab.room.world.tick > 0
    assert lab.desk.kinds() == ["expert_joined", "expert_joined"]
    assert [text["trial"] for text in page.texts if text["type"] == "welcome"] == [0, 1]
    assert lab.texts("agents", BEN)[-1]["trial"] == 1
    assert lab.texts("experts", BEN)[-1]["lead"] == ANNA


async def test_a_fault_between_two_trials_is_told_and_the_run_is_opened_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It is not tried again and again with nobody hearing of it, and no trial is begun twice."""
    lab = Lab(short_run(80))
    page = await lab.start()

    def fail(room: LearningRoom) -> None:
        raise JournalError("a part is missing")

    monkeypatch.setattr(lab.run.experts, "show", fail)
    for _ in range(400):
        if page.closed:
            break
        await lab.play(1)
    assert page.closed == (CloseCode.TRY_LATER, "this run had a fault; it is opened again")
    assert lab.runs.held == {}
    again = await lab.join()
    await lab.play(8)
    assert again.closed is None
    assert len(lab.desk.trials) == 2
    assert (lab.room.session.up.trial, lab.room.world.tick > 0) == (1, True)
