"""Guards who takes part in a learning run: leads and their hand-over, others, workers."""

from __future__ import annotations

from server.live import wire as live_wire
from tests.server.live.learning.lab import (
    ANNA,
    BEN,
    Lab,
    for_person,
    short_run,
)
from tests.server.live.stage import Listener


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
