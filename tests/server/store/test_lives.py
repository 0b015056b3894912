"""Guards what staff do with participations: reasons kept, places given back, tombstones left.

Each test runs on SQLite and on a real PostgreSQL server.
"""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from itertools import count
from typing import Any

import pytest
from sqlalchemy import func, select

from server.desks.lives import AlreadyErased, LifeDesk
from server.desks.participants import ParticipantDesk
from server.desks.trials import StoredTrialDesk
from server.export.bundle import ExportOptions, stream_export
from server.live.ports import TrialBatch, TrialResult
from server.store.claims import list_held
from server.store.engine import Database
from server.store.lives import PARTS_OF_A_TRIAL
from server.store.participants import UnknownParticipant
from server.store.tables import (
    Claim,
    PanelId,
    Participant,
    ParticipantChange,
    Response,
    Trial,
)
from study.config import Study
from study.errors import InvalidValue, UnknownToken, WrongStep
from study.protocol.lifecycle import WrongChange
from study.records.events import JournalEvent
from study.records.journal import JournalChunk

MakeResult = Callable[..., TrialResult]
NUMBERS = count()
FORMS = {
    "consent": {"adult": "yes", "informed": "yes", "agreed": "yes"},
    "browser-check": {"keyboard": "yes", "mouse": "yes", "webgl": "yes", "touch_only": "no"},
    "demographics": {"age": "31", "gender": "man", "games_3d": "daily", "colour_vision": "no"},
}
RATINGS = {f"Q{k}": "3" for k in range(1, 7)}


class Site:
    """A study on a database whose clock is turned by hand."""

    def __init__(self, database: Database, study: Study, make_result: MakeResult) -> None:
        self.now = datetime(2026, 1, 1, tzinfo=UTC)
        self.database, self.study, self.make_result = database, study, make_result
        self.people = ParticipantDesk(
            database, {study.study_id: study}, b"k" * 32, lambda: self.now
        )
        self.desk = StoredTrialDesk(
            database, policy_for=lambda study, condition: None, clock=lambda: self.now
        )
        self.staff = LifeDesk(database, lambda: self.now)

    async def walk_to(self, wanted: str, token: str | None = None) -> str:
        token = token or await self.people.join(
            self.study.study_id, "", {"PROLIFIC_PID": f"pid-{next(NUMBERS)}"}
        )
        while (step := (await self.look(token)).progress.page) != wanted:
            if step == "practice" or step.startswith("trial-"):
                opened = await self.desk.open_trial(token)
                await self.desk.commit([batch(opened.setup.trial_id)])
                await self.desk.finish(opened.setup.trial_id, self.make_result())
            else:
                form = RATINGS if step.startswith("questionnaire") else FORMS.get(step, {})
                await self.people.submit(token, step, form)
        return token

    async def look(self, token: str) -> Any:
        return (await self.people.look_up(token)).participant

    async def count(self, table: type) -> int:
        async with self.database.reading() as session:
            return await session.scalar(select(func.count()).select_from(table)) or 0

    async def history(self, code: str) -> list[tuple[str | None, str, str]]:
        _, changes = await self.staff.read_history(code)
        return [(entry.was, entry.now, entry.actor) for entry in changes]


def batch(trial_id: str) -> TrialBatch:
    chunk = JournalChunk(1, 1, b"\x00", (), 1)
    event = JournalEvent(0, 1, "connected", datetime(2026, 1, 1, tzinfo=UTC))
    return TrialBatch(trial_id, chunk, (event,), 1, "running")


@pytest.fixture
def site(database: Database, study: Study, make_result: MakeResult) -> Site:
    return Site(database, study, make_result)


async def test_a_whole_life_is_kept_with_its_reasons(site: Site) -> None:
    token = await site.walk_to("debrief")
    code = (await site.look(token)).code
    await site.staff.exclude(code, "typed only fives", "maria")
    await site.staff.reinstate(code.lower(), "was a mistake", "ben")
    await site.people.withdraw(token)
    assert await site.history(code) == [
        (None, "joined", "participant"),
        ("joined", "active", "participant"),
        ("active", "completed", "participant"),
        ("completed", "excluded", "maria"),
        ("excluded", "completed", "ben"),
        ("completed", "withdrawn", "participant"),
    ]
    _, changes = await site.staff.read_history(code)
    assert changes[3].reason == "typed only fives"


async def test_who_is_away_is_paused_and_comes_back(site: Site) -> None:
    token = await site.walk_to("demographics")
    site.now += timedelta(minutes=6)
    assert await site.people.sweep() == 0
    assert (await site.look(token)).progress.life.status == "paused"
    await site.people.visit(token)
    assert (await site.look(token)).progress.life.status == "active"
    await site.walk_to("trial-1", token)
    opened = await site.desk.open_trial(token)
    site.now += timedelta(minutes=6)
    await site.people.sweep()
    await site.desk.commit([batch(opened.setup.trial_id)])
    assert (await site.look(token)).progress.life.status == "active"
    site.now += timedelta(hours=2)
    assert await site.people.sweep() == 1
    assert (await site.look(token)).progress.page == "timed-out"


async def test_excluding_gives_the_place_back_and_reinstating_takes_it_again(site: Site) -> None:
    token = await site.walk_to("trial-2")
    opened = await site.desk.open_trial(token)
    await site.desk.commit([batch(opened.setup.trial_id)])
    code, slot = (await site.look(token)).code, (await site.look(token)).slot

    async def held() -> list[Any]:
        async with site.database.reading() as session:
            return await list_held(session, "demo", "pilot", [1])

    for _ in range(2):
        await site.staff.exclude(code, "a test", "maria")
        assert await held() == []
        assert (await site.look(token)).progress.page == "excluded"
        with pytest.raises(WrongStep):
            await site.desk.open_trial(token)
        await site.staff.reinstate(code, "a test", "maria")
        assert await held() == [slot]
    again = await site.desk.open_trial(token)
    assert again.journal == (await site.desk.open_trial(token)).journal != ()
    assert await site.desk.commit([batch(opened.setup.trial_id)]) == set()
    await site.walk_to("debrief", token)
    async with site.database.reading() as session:
        kinds = list(await session.scalars(select(Claim.kind).order_by(Claim.id)))
    assert kinds == ["claimed", "released", "claimed", "released", "claimed", "completed"]


async def test_unfit_requests_of_staff_change_nothing(site: Site) -> None:
    token = await site.walk_to("consent")
    code = (await site.look(token)).code
    with pytest.raises(WrongChange):
        await site.staff.reinstate(code, "why not", "maria")
    with pytest.raises(InvalidValue, match="reason"):
        await site.staff.exclude(code, "  ", "maria")
    with pytest.raises(UnknownParticipant, match="no participant “P-NOBODY”"):
        await site.staff.exclude("P-NOBODY", "why not", "maria")
    assert len(await site.history(code)) == 1


async def test_erasing_leaves_a_tombstone_and_nothing_else(site: Site) -> None:
    other = await site.walk_to("trial-2")
    token = await site.walk_to("questionnaire-2")
    code = (await site.look(token)).code
    await site.staff.exclude(code, "Mr Smith asked me to", "maria")
    assert await site.count(Trial) == 5
    gone = await site.staff.erase(code, "maria")
    assert (gone["panel_ids"], gone["trials"], gone["trial_chunks"]) == (1, 3, 3)
    left = [await site.count(table) for table in (Participant, PanelId, Trial)]
    assert left == [2, 1, 2]
    async with site.database.reading() as session:
        owner = (await site.look(other)).id
        assert set(await session.scalars(select(Response.participant_id))) == {owner}
        reasons = list(await session.scalars(select(ParticipantChange.reason)))
        for table in PARTS_OF_A_TRIAL:
            ids = set(await session.scalars(select(table.trial_id)))  # type: ignore[attr-defined]
            assert ids <= set(await session.scalars(select(Trial.id)))
    assert not [reason for reason in reasons if "Smith" in reason]
    with pytest.raises(UnknownToken):
        await site.people.look_up(token)
    with pytest.raises(AlreadyErased):
        await site.staff.erase(code, "maria")
    assert b"".join([piece async for piece in stream_export(site.database, ExportOptions("demo"))])


async def test_a_trial_whose_data_are_erased_while_it_runs_ends_quietly(site: Site) -> None:
    token = await site.walk_to("trial-1")
    opened = await site.desk.open_trial(token)
    await site.staff.erase((await site.look(token)).code, "maria")
    trial_id = opened.setup.trial_id
    assert await site.desk.commit([batch(trial_id)]) == {trial_id}
    await site.desk.finish(trial_id, site.make_result())
    assert await site.count(Trial) == 0
