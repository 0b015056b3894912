"""Guards what the live loop relies on: trials opened once, journals stored once, ends counted once.

Each test runs on SQLite and on a real PostgreSQL server.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from datetime import UTC, datetime

import pytest
from sqlalchemy import func, select

from server.desks.participants import ParticipantDesk
from server.desks.trials import StoredTrialDesk
from server.live.ports import OpenTrial, TrialBatch, TrialResult
from server.store.engine import Database
from server.store.journals import read_journal
from server.store.participants import hash_token
from server.store.tables import Claim, Participant, Trial, TrialLeg
from study.config import Study
from study.errors import NotAllowedLive, PolicyError, UnknownToken, WrongStep
from study.protocol.orders import Slot, practice_seed, trial_seed
from study.records.events import JournalEvent
from study.records.journal import JournalChunk
from study.warehouse.halls import PRESETS

MakeResult = Callable[..., TrialResult]
FORMS = {
    "consent": {"adult": "yes", "informed": "yes", "agreed": "yes"},
    "browser-check": {"keyboard": "yes", "mouse": "yes", "webgl": "yes", "touch_only": "no"},
    "demographics": {
        "age": "31",
        "gender": "man",
        "games_3d": "daily",
        "colour_vision": "no",
    },
}
RATINGS = {f"Q{k}": "3" for k in range(1, 7)}


class Site:
    """A study on a database, and a way through it."""

    def __init__(self, database: Database, study: Study, make_result: MakeResult) -> None:
        self.database = database
        self.study = study
        self.make_result = make_result
        self.people = ParticipantDesk(database, {study.study_id: study}, b"k" * 32)
        self.desk = StoredTrialDesk(database)

    async def walk_to(self, wanted: str, token: str | None = None) -> str:
        token = token or await self.people.join(self.study.study_id, "", {})
        while (step := await self.step(token)) != wanted:
            if step == "practice" or step.startswith("trial-"):
                await self.end(await self.desk.open_trial(token))
            else:
                form = RATINGS if step.startswith("questionnaire") else FORMS.get(step, {})
                await self.people.submit(token, step, form)
        return token

    async def step(self, token: str) -> str:
        return (await self.people.look_up(token)).participant.progress.page

    async def end(self, opened: OpenTrial, status: str = "completed") -> None:
        await self.desk.finish(opened.setup.trial_id, self.make_result(status))

    async def count(self, table: type) -> int:
        async with self.database.reading() as session:
            return await session.scalar(select(func.count()).select_from(table)) or 0


@pytest.fixture
def site(database: Database, study: Study, make_result: MakeResult) -> Site:
    return Site(database, study, make_result)


async def test_a_trial_is_opened_once_with_its_full_configuration(site: Site) -> None:
    token = await site.walk_to("practice")
    first, second = await site.desk.open_trial(token), await site.desk.open_trial(token)
    assert first == second
    setup = first.setup
    assert (setup.kind, setup.scale, setup.condition) == ("practice", "practice", "none")
    assert (setup.label, setup.mode, setup.policy) == ("Practice", "pilot", None)
    assert setup.spec == PRESETS["practice"]
    assert setup.seed == practice_seed(site.study.seed, 1)
    assert await site.count(Trial) == 1


async def test_trials_follow_the_order_given_and_the_seeds_of_its_block(site: Site) -> None:
    token = await site.walk_to("trial-1")
    slot = (await site.people.look_up(token)).participant.slot
    assert slot is not None
    for position in (1, 2, 3):
        await site.walk_to(f"trial-{position}", token)
        setup = (await site.desk.open_trial(token)).setup
        assert setup.condition == site.study.orders[slot.order_index][position - 1]
        assert setup.seed == trial_seed(site.study.seed, slot.block, position)
        assert setup.label == f"Display {'ABC'[position - 1]}"
        assert (setup.policy is not None) == (setup.condition == "varil")


async def test_only_a_trial_step_opens_a_trial(site: Site) -> None:
    token = await site.walk_to("demographics")
    with pytest.raises(WrongStep) as caught:
        await site.desk.open_trial(token)
    assert caught.value.current == "demographics"
    with pytest.raises(UnknownToken):
        await site.desk.open_trial("x" * 32)


def batch(trial_id: str, first_tick: int, number: int) -> TrialBatch:
    chunk = JournalChunk(first_tick, 2, b"\x00\x01\x01\xff\xff", ((first_tick, b"\x00" * 8),), 7)
    event = JournalEvent(number, first_tick, "paused", datetime.now(UTC), {"reason": "silent"})
    return TrialBatch(trial_id, chunk, (event,), first_tick + 1, "running")


async def test_a_journal_comes_back_as_it_was_and_each_part_is_stored_once(site: Site) -> None:
    token = await site.walk_to("practice")
    trial_id = (await site.desk.open_trial(token)).setup.trial_id
    sent = [batch(trial_id, 1, 0), batch(trial_id, 3, 1)]
    await site.desk.commit(sent)
    await site.desk.commit([*sent, batch(trial_id, 5, 2)])
    await site.desk.commit([])
    opened = await site.desk.open_trial(token)
    assert [chunk.first_tick for chunk in opened.journal] == [1, 3, 5]
    assert opened.journal[:2] == tuple(b.chunk for b in sent)
    assert opened.events[:2] == tuple(event for b in sent for event in b.events)


async def test_a_trial_that_is_gone_holds_up_no_other(site: Site) -> None:
    """An erased trial is reported as over; what comes with it is stored."""
    token = await site.walk_to("practice")
    trial_id = (await site.desk.open_trial(token)).setup.trial_id
    over = await site.desk.commit([batch(trial_id, 1, 0), batch("gone", 1, 0)])
    assert set(over) == {"gone"}
    async with site.database.reading() as session:
        chunks, _ = await read_journal(session, trial_id)
    assert [chunk.first_tick for chunk in chunks] == [1]


async def test_an_end_counts_once_and_moves_the_participant_with_it(site: Site) -> None:
    token = await site.walk_to("trial-1")
    opened = await site.desk.open_trial(token)
    await site.end(opened)
    await site.end(opened)
    assert await site.step(token) == "questionnaire-1"
    async with site.database.reading() as session:
        row = (await session.scalars(select(Trial).where(Trial.id == opened.setup.trial_id))).one()
        legs = await session.scalar(
            select(func.count())
            .select_from(TrialLeg)
            .where(TrialLeg.trial_id == opened.setup.trial_id)
        )
    measures = site.make_result().measures
    assert (row.status, row.ticks, row.sum_wait_s) == ("completed", 3000, measures.sum_wait_s)
    assert legs == len(measures.legs)


async def test_the_practice_is_tried_again_with_another_world_and_then_ends_it(site: Site) -> None:
    token = await site.walk_to("practice")
    seeds = set()
    for _ in range(3):
        assert await site.step(token) == "practice"
        opened = await site.desk.open_trial(token)
        seeds.add(opened.setup.seed)
        await site.end(opened, "timed_out")
        if await site.step(token) == "instructions":
            await site.people.submit(token, "instructions", {})
    assert await site.step(token) == "screened-out"
    assert len(seeds) == 3
    assert await site.count(Claim) == 0


async def test_an_abandoned_trial_releases_its_place_for_the_next(site: Site) -> None:
    token = await site.walk_to("trial-1")
    left = (await site.people.look_up(token)).participant.slot
    await site.end(await site.desk.open_trial(token), "abandoned")
    assert await site.step(token) == "timed-out"
    others = [await site.walk_to("explanation-1") for _ in range(6)]
    slots = {(await site.people.look_up(other)).participant.slot for other in others}
    assert slots == {Slot(0, k) for k in range(6)}
    assert left in slots


async def test_people_who_arrive_together_get_different_places(site: Site) -> None:
    tokens = [await site.walk_to("practice") for _ in range(6)]
    opened = [await site.desk.open_trial(token) for token in tokens]
    await asyncio.gather(*(site.end(trial) for trial in opened))
    slots = {(await site.people.look_up(token)).participant.slot for token in tokens}
    assert slots == {Slot(0, k) for k in range(6)}


async def test_the_same_form_sent_at_once_makes_one_row_per_answer(site: Site) -> None:
    token = await site.walk_to("demographics")
    await asyncio.gather(
        *(site.people.submit(token, "demographics", FORMS["demographics"]) for _ in range(5))
    )
    assert await site.step(token) == "instructions"


async def test_a_withdrawal_during_a_trial_stays_whatever_the_world_still_reports(
    site: Site,
) -> None:
    token = await site.walk_to("trial-2")
    opened = await site.desk.open_trial(token)
    await site.people.withdraw(token)
    await site.people.withdraw(token)
    trial_id = opened.setup.trial_id
    assert set(await site.desk.commit([batch(trial_id, 1, 0)])) == {trial_id}
    await site.end(opened)
    assert await site.step(token) == "withdrawn"
    async with site.database.reading() as session:
        status = await session.scalar(select(Trial.status).where(Trial.id == trial_id))
        chunks = await read_journal(session, trial_id)
    assert status == "abandoned"
    assert chunks == ((), ()), "nothing is recorded after a withdrawal"


async def test_tokens_are_stored_hashed_only(site: Site) -> None:
    token = await site.people.join("demo", "", {})
    async with site.database.reading() as session:
        row = (await session.scalars(select(Participant))).one()
    assert row.token_hash == hash_token(token)
    assert token not in repr([getattr(row, c.key) for c in Participant.__table__.columns])


async def test_a_time_scale_is_refused_for_live_participants(
    database: Database, study: Study, make_result: MakeResult
) -> None:
    site = Site(database, study.revised(recruiting="live"), make_result)
    site.desk = StoredTrialDesk(database)
    token = await site.walk_to("practice")
    with pytest.raises(NotAllowedLive, match="time scale"):
        await StoredTrialDesk(database, time_scale=4.0).open_trial(token)


async def test_a_policy_made_for_other_thresholds_is_refused(
    database: Database, study: Study, make_result: MakeResult
) -> None:
    other = study.revised(thresholds={"close_m": 4.0}, conditions=("varil",))
    site = Site(database, other, make_result)
    token = await site.walk_to("trial-1")
    with pytest.raises(PolicyError, match="close_m"):
        await site.desk.open_trial(token)
