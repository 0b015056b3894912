"""Guards the export: it equals the database, whatever people typed and however they left."""

from __future__ import annotations

import asyncio
import csv
import hashlib
import io
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from sqlalchemy import select

from server.export import stream_export, study_items, write_export
from server.live.ports import TrialResult
from server.participant_desk import ParticipantDesk
from server.settings import Settings
from server.store.engine import Database
from server.store.schema import SchemaMismatch, migrate
from server.store.tables import Participant, Response, Trial, TrialRobot
from server.trial_desk import StoredTrialDesk
from study.config import Study
from study.errors import UnknownStudy
from study.records.tables import TABLES, neutralise_formula

MakeResult = Callable[..., TrialResult]
CONSENT = {"adult": "yes", "informed": "yes", "agreed": "yes"}
DEVICE = {"keyboard": "yes", "mouse": "yes", "webgl": "yes", "touch_only": "no"}
PERSON = {"age": "31", "gender": "man", "games_3d": "daily", "colour_vision": "no"}
PRINTABLE = st.characters(exclude_categories=["Cs", "Cc"])
REMARKS = st.text(PRINTABLE, max_size=40) | st.sampled_from(
    ["=cmd|' /C calc'!A0", "@SUM(1)", '"quoted", and; more', "line\none", "-5", "naïve 🤖"]
)


async def read_bundle(database: Database, mode: str | None = None) -> dict[str, list[Any]]:
    pieces = [piece async for piece in stream_export(database, "demo", mode)]
    with zipfile.ZipFile(io.BytesIO(b"".join(pieces))) as bundle:
        assert bundle.testzip() is None
        for line in bundle.read("MANIFEST.sha256").decode().splitlines():
            digest, name = line.split("  ")
            assert hashlib.sha256(bundle.read(name)).hexdigest() == digest
        return {
            name.removesuffix(".csv"): list(
                csv.DictReader(io.StringIO(bundle.read(name).decode(), newline=""))
            )
            for name in bundle.namelist()
            if name.endswith(".csv")
        }


class Site:
    """People of a study on a database, walked as far as told."""

    def __init__(self, database: Database, study: Study, make_result: MakeResult) -> None:
        self.people = ParticipantDesk(database, {"demo": study}, b"k" * 32)
        self.desk = StoredTrialDesk(database, policy_for=lambda study, condition: None)
        self.make_result = make_result
        self.database = database

    async def walk(self, steps: int, rating: str, remark: str) -> str:
        token = await self.people.join("demo", "", {"PROLIFIC_PID": "panel-id"})
        for _ in range(steps):
            step = (await self.people.look_up(token)).participant.progress.page
            if step == "practice" or step.startswith("trial-"):
                opened = await self.desk.open_trial(token)
                await self.desk.finish(opened.setup.trial_id, self.make_result())
                continue
            forms = {
                "consent": CONSENT,
                "browser-check": DEVICE,
                "demographics": PERSON,
                "comments": {"remarks": remark},
            }
            ratings = {f"Q{k}": rating for k in range(1, 7)}
            form = ratings if step.startswith("questionnaire") else forms.get(step, {})
            await self.people.submit(token, step, form)
        return token


@pytest.fixture
def site(database: Database, study: Study, make_result: MakeResult) -> Site:
    return Site(database, study, make_result)


async def check_export_equals_database(database: Database) -> None:
    tables = await read_bundle(database)
    async with database.reading() as session:
        people = {p.id: p for p in await session.scalars(select(Participant))}
        kept = {key: p for key, p in people.items() if p.status != "withdrawn"}
        trials = [
            t
            for t in await session.scalars(select(Trial))
            if t.participant_id in kept and t.kind == "trial"
        ]
        ids = {t.id for t in trials}
        robots = [r for r in await session.scalars(select(TrialRobot)) if r.trial_id in ids]
        answers = [r for r in await session.scalars(select(Response)) if r.participant_id in kept]
    assert {(r["participant_code"], r["status"]) for r in tables["participants"]} == {
        (p.code, p.status) for p in people.values()
    }
    assert {
        (r["trial_id"], r["position"], r["seed"], r["sum_wait_s"]) for r in tables["trials"]
    } == {
        (t.id, str(t.position), str(t.seed), "" if t.sum_wait_s is None else repr(t.sum_wait_s))
        for t in trials
    }
    assert sorted((r["trial_id"], r["robot"], r["wait_s"]) for r in tables["robots"]) == sorted(
        (r.trial_id, str(r.robot), repr(r.wait_s)) for r in robots
    )
    told = sorted(
        (r["participant_code"], r["step"], r["item"], r["value"]) for r in tables["responses"]
    )
    assert told == sorted(
        (people[r.participant_id].code, r.step, r.item, neutralise_formula(r.value))
        for r in answers
    )


@given(
    people=st.lists(
        st.tuples(st.integers(0, 16), st.sampled_from("12345"), REMARKS, st.booleans()), max_size=3
    )
)
@settings(
    max_examples=12, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
def test_the_export_equals_the_database(
    people: list[tuple[int, str, str, bool]],
    study: Study,
    make_result: MakeResult,
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    """People who leave anywhere, withdraw or not, and write anything."""

    async def run(url: str) -> None:
        database = Database(url)
        await migrate(database)
        site = Site(database, study, make_result)
        await site.people.register_studies()
        for steps, rating, remark, withdraws in people:
            token = await site.walk(min(steps, 15), rating, remark)
            if withdraws:
                await site.people.withdraw(token)
        await check_export_equals_database(database)
        await database.close()

    asyncio.run(run(f"sqlite:///{tmp_path_factory.mktemp('export')}/a.sqlite3"))


async def test_a_whole_participation_on_each_kind_of_database(site: Site) -> None:
    await site.walk(15, "4", "=1+1")
    await check_export_equals_database(site.database)
    tables = await read_bundle(site.database)
    assert [len(tables[name]) for name in TABLES] == [1, 3, 6, 9, 3 + 6 + 4 + 18 + 2]
    (person,) = tables["participants"]
    order = person["condition_order"].split(">")
    assert [row["condition"] for row in tables["trials"]] == order
    ratings = [row for row in tables["responses"] if row["instrument"] == "questionnaire"]
    assert {(row["position"], row["condition"]) for row in ratings} == {
        (str(k), name) for k, name in enumerate(order, 1)
    }
    assert {row["label"] for row in ratings} == {"Somewhat agree"}
    assert {row["value"] for row in tables["responses"] if row["item"] == "remarks"} == {"'=1+1"}


async def test_nothing_in_the_export_leads_back_to_a_person(site: Site) -> None:
    token = await site.walk(15, "4", "")
    pieces = [piece async for piece in stream_export(site.database, "demo", None)]
    with zipfile.ZipFile(io.BytesIO(b"".join(pieces))) as bundle:
        whole = b"".join(bundle.read(name) for name in bundle.namelist())
    assert token.encode() not in whole
    assert b"panel-id" not in whole


async def test_columns_do_not_depend_on_what_was_answered(site: Site) -> None:
    await site.people.register_studies()
    pieces = [piece async for piece in stream_export(site.database, "demo", None)]
    with zipfile.ZipFile(io.BytesIO(b"".join(pieces))) as bundle:
        for table in TABLES.values():
            assert bundle.read(table.file).decode() == ",".join(table.header) + "\n"


async def test_modes_are_kept_apart(site: Site) -> None:
    await site.walk(0, "1", "")
    assert len((await read_bundle(site.database, "pilot"))["participants"]) == 1
    assert len((await read_bundle(site.database, "live"))["participants"]) == 0


async def test_every_answer_seen_is_in_the_codebook(site: Site, study: Study) -> None:
    await site.walk(15, "4", "")
    tables = await read_bundle(site.database)
    listed = {row["name"] for row in tables["codebook"]}
    assert {f"{r['instrument']}.{r['item']}" for r in tables["responses"]} <= listed
    items = list(study_items(study.config_hash, study))
    assert {f"{entry.instrument}.{entry.item}" for entry in items} <= listed


async def test_an_unknown_study_is_refused(database: Database) -> None:
    with pytest.raises(UnknownStudy):
        await anext(stream_export(database, "nope", None))


async def test_a_file_appears_only_when_it_is_complete(site: Site, tmp_path: Path) -> None:
    await site.walk(15, "4", "")
    config, out = Settings(database_url=site.database.url), tmp_path / "out.zip"
    if site.database.file is None:
        config = Settings(database_url=site.database.url.replace("+asyncpg", ""))
    assert (await write_export(config, "demo", None, out))["trials"] == 3
    with pytest.raises(UnknownStudy):
        await write_export(config, "nope", None, tmp_path / "none.zip")
    assert [file.name for file in tmp_path.iterdir() if ".zip" in file.name] == ["out.zip"]


async def test_an_export_from_another_schema_is_refused(tmp_path: Path) -> None:
    empty = Settings(var_dir=tmp_path)
    with pytest.raises(SchemaMismatch, match="varil migrate"):
        await write_export(empty, "demo", None, tmp_path / "a.zip")
