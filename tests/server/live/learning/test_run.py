"""Guards live learning runs: what experts are told, what is stored, how a run ends."""

from __future__ import annotations

from dataclasses import replace

import pytest

from server.live import wire as live_wire
from server.live.learning import wire
from server.live.learning.ports import RunEnded
from study.learning.settings import LearningSettings
from tests.server.live.learning.lab import (
    ANNA,
    BEN,
    RUN,
    SETUP,
    Lab,
    MemoryLearningDesk,
    for_person,
    settle,
    short_run,
)
from tests.server.live.stage import Listener


def declutter(lab: Lab) -> None:
    """An expert who wants nothing of robot 0."""
    room = lab.room
    if room.result is None and room.world.tick % 30 == 1:
        lab.edit(room.session.up.run_tick(room.world.tick), (0, 0, 7))


async def test_the_first_words_to_a_page() -> None:
    """The run, then the trial as a participant sees it, then who is there and what they see."""
    lab = Lab()
    page = await lab.join()
    kinds = [text["type"] for text in page.texts]
    wanted = ["run", "welcome", "phase", "curve", "agreement", "experts", "agents", "progress"]
    assert kinds[:8] == wanted
    run = page.texts[0]
    assert (run["run_id"], run["robots"], run["stations"]) == (RUN, SETUP.spec.robots, 4)
    assert run["you"] == {"name": "anna", "client": ANNA}
    assert run["settings"]["iterations"] == 12
    assert (page.texts[1]["kind"], page.texts[1]["trial"]) == ("learning", 0)
    assert lab.texts("experts")[-1]["lead"] == ANNA
    agents = lab.texts("agents")[-1]
    count = SETUP.spec.robots + 4
    for name in ("boxes", "proposals", "drawn", "by_expert"):
        assert len(agents[name]) == count, name
    assert agents["recording"]


async def test_pairs_versions_and_curve_of_a_run_to_its_end() -> None:
    """Everything is stored once, the policies name their origin, and all hear of the end."""
    lab = Lab(short_run(6))
    page = await lab.start()
    for _ in range(400):
        if lab.desk.status != "open" and page.closed:
            break
        await lab.play(1, declutter)
    desk = lab.desk
    assert (desk.status, desk.iteration, len(desk.pairs)) == ("finished", 6, 150)
    assert sorted(desk.versions) == list(range(7))
    assert lab.texts("ended") == [{"type": "ended", "status": "finished"}]
    assert page.closed is not None
    assert page.closed[0] == 1000
    assert lab.runs.held == {}
    opened = await desk.open_run(RUN)
    last = opened.versions[-1].policy
    assert (last.origin, last.name) == ("people", "people-000000-006")
    assert last.training is not None
    assert last.training["settings"]["worker"] == "simulated"
    curve = lab.texts("curve")
    assert sum(len(part["lines"]["policy"]["disable"]) for part in curve) == 6
    assert [part["from"] for part in curve] == sorted(part["from"] for part in curve)
    progress = lab.texts("progress")[-1]
    assert (progress["iteration"], progress["policy_sha256"]) == (6, last.sha256)
    assert desk.results[desk.trials[-1][0].trial_id].ticks > 0


async def test_an_edit_is_acknowledged_when_it_is_stored() -> None:
    """While the database is away nothing is said; afterwards the newest number, once."""
    lab = Lab()
    await lab.start()
    lab.edit(1, (0, 0, 1))
    lab.edit(2, (1, 0, 1))
    assert lab.texts("agents")[-1]["boxes"][:2] == [6, 6]
    assert [text["taken_seq"] for text in lab.texts("agents")[-3:]] == [0, 1, 2]
    lab.desk.failures = 2
    for _ in range(2):
        assert not await lab.hall.writer.flush()
        assert lab.texts("stored") == []
    assert await lab.hall.writer.flush()
    assert lab.texts("stored") == [{"type": "stored", "seq": 2}]
    lab.edit(2, (2, 0, 1))
    assert lab.texts("stored")[1:] == [{"type": "stored", "seq": 2}]
    assert lab.texts("agents")[-1]["boxes"][2] == 7


@pytest.mark.parametrize(
    ("message", "says"),
    [
        (wire.Edit(1, 0, 1, ((0, 0, 1), (99, 1, 0))), "no agent 99"),
        (wire.Edit(1, 0, 10**6, ((0, 0, 1),)), "has not come yet"),
        (wire.Edit(1, 5, 1, ((0, 0, 1),)), "trial 6 is not the present one"),
        (wire.Confirm(1, 0, 1, (0, 77)), "no agent 77"),
    ],
)
async def test_a_refused_message_leaves_no_trace(
    message: wire.Edit | wire.Confirm, says: str
) -> None:
    lab = Lab()
    await lab.start()
    before = lab.desk.kinds()
    lab.run.edit(lab.seats[ANNA], message)
    await lab.play(1)
    (refused,) = lab.texts("refused")
    assert refused["seq"] == 1
    assert says in refused["message"]
    assert lab.desk.kinds() == before
    assert lab.texts("agents")[-1]["boxes"][0] == 7
    assert lab.texts("stored") == []


async def test_pairs_pause_while_the_lead_is_away_and_the_world_goes_on() -> None:
    lab = Lab()
    await lab.start()
    await lab.join(BEN)
    await lab.play(8)
    taken, tick = len(lab.desk.pairs), lab.room.world.tick
    assert taken > 0
    lab.leave()
    await lab.play(8)
    assert len(lab.desk.pairs) == taken
    assert lab.room.world.tick >= tick + 235
    assert not lab.texts("agents", BEN)[-1]["recording"]
    assert lab.texts("experts", BEN)[-1]["lead"] is None
    lab.run.take_lead(lab.seats[BEN])
    await lab.play(8)
    assert len(lab.desk.pairs) > taken


async def test_the_lead_changes_hands_and_the_others_are_rated() -> None:
    lab = Lab(short_run(80))
    await lab.start()
    await lab.join(BEN)
    lab.edit(1, (0, 0, 7), client=BEN)
    lab.run.hand_over(lab.seats[BEN], BEN)
    assert lab.texts("experts", BEN)[-1]["lead"] == ANNA, "only who leads can hand over"
    await lab.play(9)
    (rated,) = lab.texts("agreement", BEN)[-1]["experts"]
    assert rated["name"] == "ben"
    assert rated["elements"]["live_location"]["pairs"] > 0
    assert {rating.expert for rating in lab.desk.ratings.values()} == {"ben"}
    lab.run.hand_over(lab.seats[ANNA], BEN)
    assert lab.texts("experts")[-1]["lead"] == BEN
    lab.edit(2, (0, 0, 4), client=BEN)
    assert lab.room.session.up.boxes.masks[0] == 3, "the run's boxes are ben's now"
    await lab.play(8)
    assert {rating.expert for rating in lab.desk.ratings.values()} == {"ben", "anna"}


async def test_a_simulated_worker_leaves_a_minute_after_the_last_expert() -> None:
    lab = Lab()
    await lab.start()
    lab.leave()
    await lab.play(58)
    assert lab.room.phase == "running"
    await lab.play(4)
    assert lab.room.phase == "paused"
    tick = lab.room.world.tick
    await lab.play(5)
    assert lab.room.world.tick == tick
    await lab.join()
    await lab.play(5)
    assert lab.room.phase == "running"
    assert lab.room.world.tick > tick


async def test_a_long_stall_does_not_stop_the_simulated_worker() -> None:
    lab = Lab()
    await lab.start()
    lab.clock.pass_s(60)
    await lab.play(5)
    assert lab.room.phase == "running"


async def test_a_newer_connection_of_a_page_takes_its_seat() -> None:
    lab = Lab()
    first = await lab.start()
    lab.edit(4, (0, 0, 1))
    old_seat = lab.seats[ANNA]
    second = await lab.join()
    assert first.closed is not None
    assert first.closed[0] == live_wire.CloseCode.TAKEN_OVER
    lab.run.leave(old_seat)
    assert second.texts[0]["taken_seq"] == 4
    assert lab.texts("experts")[-1]["lead"] == ANNA
    count = len(first.snapshots)
    await lab.play(1)
    assert len(first.snapshots) == count
    assert second.snapshots


async def test_a_run_stopped_elsewhere_is_noticed_while_the_world_stands() -> None:
    """Nobody works, so nothing is to be stored; the run asks now and then all the same."""
    lab = Lab(for_person())
    page = await lab.join()
    await lab.play(2)
    lab.desk.status = "stopped"
    await lab.play(8)
    assert lab.texts("ended") == [{"type": "ended", "status": "stopped"}]
    assert page.closed is not None
    assert page.closed[0] == live_wire.CloseCode.NO_TRIAL
    assert lab.runs.held == {}
    with pytest.raises(RunEnded):
        await lab.runs.open(RUN)


async def test_a_person_works_as_in_any_trial() -> None:
    """The protocol of participants: join, ready, countdown, pause on leaving."""
    lab = Lab(for_person())
    await lab.join()
    room = await lab.runs.enter("token")
    assert room is lab.room
    worker = Listener()
    room.join(worker)
    assert worker.texts[0]["type"] == "welcome"
    room.take_ready()
    await lab.play(5)
    assert room.phase == "running"
    room.leave(worker, 1001)
    assert room.phase == "paused"
    assert lab.texts("phase")[-1]["phase"] == "paused"


async def test_the_server_stops_and_everything_is_stored() -> None:
    """The trial pauses, pages are told to come again, and who was there has left."""
    lab = Lab()
    page = await lab.start()
    await lab.play(3)
    lab.edit(1, (0, 0, 1))
    await lab.hall.stop()
    await lab.runs.stop()
    assert page.closed is not None
    assert page.closed[0] == live_wire.CloseCode.RESTARTING
    assert lab.desk.kinds() == ["expert_joined", "lead_changed", "expert_set", "expert_left"]
    assert lab.texts("ended") == []


async def test_a_run_that_has_ended_still_has_its_curve_to_show() -> None:
    lab = Lab(short_run(2))
    await lab.start()
    await lab.play(60)
    assert lab.desk.status == "finished"
    texts = await lab.runs.describe_ended(RUN, ("ben", BEN))
    assert [text.split('"')[3] for text in texts] == ["run", "curve", "agreement", "ended"]
    assert texts[1].count("[") == 15


async def test_settings_of_a_run_reach_its_beta() -> None:
    settings = LearningSettings(iterations=12, beta="first_only", classifier="majority", seed=1)
    lab = Lab(MemoryLearningDesk(replace(SETUP, settings=settings)))
    await lab.start()
    await lab.play(30)
    betas = {text["iteration"]: text["beta"] for text in lab.texts("progress")}
    assert betas[0] == 1.0
    assert betas[1] == 0.0
    await settle()
