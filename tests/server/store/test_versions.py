"""Guards versions and places: who has joined keeps the study as it was, and no place is lost.

Each test runs on SQLite and on a real PostgreSQL server.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from typing import Any

import pytest
from sqlalchemy import select, update

from server.desks.participants import ParticipantDesk
from server.desks.study_versions import register_versions
from server.desks.trials import StoredTrialDesk
from server.live.ports import TrialResult
from server.store.engine import Database
from server.store.studies import list_entries
from server.store.tables import Claim, Participant
from server.study_files import ReadStudy
from study.config import Study
from study.protocol.orders import Slot

FORMS = {
    "consent": {"adult": "yes", "informed": "yes", "agreed": "yes"},
    "browser-check": {"keyboard": "yes", "mouse": "yes", "webgl": "yes", "touch_only": "no"},
    "demographics": {"age": "31", "gender": "man", "games_3d": "daily", "colour_vision": "no"},
}
RATINGS = {f"Q{k}": "3" for k in range(1, 7)}


class Site:
    """A server's desks, which can be taken down and put up again with another study file."""

    def __init__(self, database: Database, make_result: Callable[..., TrialResult]) -> None:
        self.database, self.make_result = database, make_result
        self.trials = StoredTrialDesk(database)
        self.now = datetime.now(UTC)

    async def start(self, study: Study) -> list[str]:
        """Serve this study; returns what is said at the start."""
        self.people = ParticipantDesk(
            self.database, {study.study_id: study}, b"k" * 32, clock=lambda: self.now
        )
        sentences = await register_versions(self.database, [ReadStudy(study)])
        await self.people.register_studies()
        return sentences

    async def walk_to(self, wanted: str, token: str | None = None) -> str:
        token = token or await self.people.join("demo", "", {})
        while (step := (await self.visit(token)).participant.progress.page) != wanted:
            if step == "practice" or step.startswith("trial-"):
                opened = await self.trials.open_trial(token)
                await self.trials.finish(opened.setup.trial_id, self.make_result())
            else:
                form = RATINGS if step.startswith("questionnaire") else FORMS.get(step, {})
                await self.people.submit(token, step, form)
        return token

    async def visit(self, token: str) -> Any:
        return await self.people.look_up(token)

    async def slot(self, token: str) -> Slot | None:
        return (await self.visit(token)).participant.slot

    async def pass_practice(self, token: str) -> None:
        opened = await self.trials.open_trial(token)
        await self.trials.finish(opened.setup.trial_id, self.make_result())


@pytest.fixture
def site(database: Database, make_result: Callable[..., TrialResult]) -> Site:
    return Site(database, make_result)


async def test_who_has_joined_keeps_the_study_as_it_was(site: Site, study: Study) -> None:
    """A changed file makes a version for newcomers, and the start says so."""
    said = await site.start(study)
    assert said == [
        f"Study “demo”: version 1 ({study.config_hash[:12]}), not joined by anybody yet"
    ]
    before = await site.walk_to("instructions")
    changed = study.revised(title="Robots, revised", conditions=("none", "full"))
    (sentence,) = await site.start(changed)
    assert "has changed: version 2" in sentence
    assert f"1 who joined version 1 ({study.config_hash[:12]}) keep it" in sentence
    after = await site.walk_to("instructions")
    assert (await site.visit(before)).study.title == study.title
    assert (await site.visit(after)).study.title == "Robots, revised"
    await site.walk_to("debrief", before)
    assert (await site.visit(before)).study.config_hash == study.config_hash
    (sentence,) = await site.start(changed)
    assert sentence.endswith("frozen; joined by 1")


async def test_a_draft_that_nobody_joined_is_replaced(site: Site, study: Study) -> None:
    for seed in (1, 2, 3):
        await site.start(study.revised(seed=seed))
    async with site.database.reading() as session:
        entries = await list_entries(session, "demo")
    assert [(entry.number, entry.joined) for entry in entries] == [(1, 0)]
    assert entries[0].config_hash == study.revised(seed=3).config_hash


async def test_a_mended_text_keeps_the_balance_and_another_design_begins_anew(
    site: Site, study: Study
) -> None:
    await site.start(study)
    first = [await site.slot(await site.walk_to("explanation-1")) for _ in range(4)]
    await site.start(study.revised(title="With a mended title"))
    then = [await site.slot(await site.walk_to("explanation-1")) for _ in range(2)]
    assert sorted([*first, *then]) == [Slot(0, k) for k in range(6)]
    await site.start(study.revised(conditions=("none", "full")))
    others = [await site.slot(await site.walk_to("explanation-1")) for _ in range(2)]
    assert sorted(others) == [Slot(0, 0), Slot(0, 1)]


async def test_two_claims_of_the_last_place_at_the_same_moment(site: Site, study: Study) -> None:
    """One gets it, the other begins the next block; nobody is sent away, nothing is given twice."""
    await site.start(study)
    taken = {await site.slot(await site.walk_to("explanation-1")) for _ in range(5)}
    rivals = [await site.walk_to("practice") for _ in range(2)]
    await asyncio.gather(*(site.pass_practice(token) for token in rivals))
    given = sorted([slot for token in rivals if (slot := await site.slot(token))])
    assert given[0] in {Slot(0, k) for k in range(6)} - taken
    assert given[1].block == 1


@pytest.mark.parametrize("leaving", ["withdraw", "idle"])
async def test_a_place_is_released_and_given_to_the_next(
    site: Site, study: Study, leaving: str
) -> None:
    await site.start(study)
    tokens = [await site.walk_to("explanation-1") for _ in range(6)]
    left = await site.slot(tokens[2])
    if leaving == "withdraw":
        await site.people.withdraw(tokens[2])
    else:
        await _forget(site, tokens[2])
        assert await site.people.sweep() == 1
    assert await site.slot(await site.walk_to("explanation-1")) == left
    async with site.database.reading() as session:
        entries = (await session.scalars(select(Claim).order_by(Claim.id))).all()
    assert [entry.kind for entry in entries] == ["claimed"] * 6 + ["released", "claimed"]


async def test_modes_are_counted_apart(site: Site, study: Study) -> None:
    await site.start(study)
    pilots = {await site.slot(await site.walk_to("explanation-1")) for _ in range(6)}
    await site.start(study.revised(recruiting="live"))
    live = {await site.slot(await site.walk_to("explanation-1")) for _ in range(6)}
    assert pilots == live == {Slot(0, k) for k in range(6)}


async def test_a_latin_square_is_filled_row_by_row(site: Site, study: Study) -> None:
    square = study.revised(
        conditions=("varil", "arroch", "crmiar", "none"), order={"kind": "latin-square"}
    )
    await site.start(square)
    slots = [await site.slot(await site.walk_to("explanation-1")) for _ in range(8)]
    assert sorted(slots) == [Slot(block, k) for block in (0, 1) for k in range(4)]


async def test_each_trial_has_the_hall_and_the_limit_of_its_position(
    site: Site, study: Study
) -> None:
    own = {"name": "own", "shelf_columns": 2, "shelf_rows": 2, "robots": 2, "boxes_per_robot": 1}
    await site.start(
        study.revised(scale=["small", "own", "study"], hall=[own], limits={"trial_s": 99.0})
    )
    token, seen = await site.walk_to("practice"), []
    for step in ("practice", "trial-1", "trial-2", "trial-3"):
        await site.walk_to(step, token)
        setup = (await site.trials.open_trial(token)).setup
        seen.append((setup.scale, setup.spec.robots, setup.spec.cap_s))
    assert seen == [("practice", 1, 180.0), ("small", 6, 99.0), ("own", 2, 99.0), ("study", 12, 99)]


async def test_answers_are_stored_in_the_order_in_which_they_were_shown(
    site: Site, study: Study
) -> None:
    shuffled = {"use": "paper-q1-q6", "random_order": True}
    await site.start(study.revised(questionnaire=[shuffled]))
    token = await site.walk_to("explanation-2")
    visit = await site.visit(token)
    shown = [item.name for item in visit.instruments("questionnaire")[0].items]
    stored = await _stored_order(site, token, "questionnaire-1")
    assert stored == shown
    assert sorted(stored) == sorted(RATINGS)


async def _stored_order(site: Site, token: str, step: str) -> list[str]:
    from server.store.responses import read_answers

    participant = (await site.visit(token)).participant
    async with site.database.reading() as session:
        return list(await read_answers(session, participant.id, step))


async def _forget(site: Site, token: str) -> None:
    """Nothing was heard of this participant for longer than the limit."""
    participant = (await site.visit(token)).participant
    async with site.database.writing() as session:
        await session.execute(
            update(Participant)
            .where(Participant.id == participant.id)
            .values(seen_at=site.now - timedelta(hours=2))
        )
