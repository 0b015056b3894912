"""Guards the export: it equals the database, whatever people typed and however they left."""

from __future__ import annotations

import asyncio
import io
import json
import shutil
import zipfile
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from sqlalchemy import select

from server.export.bundle import ExportOptions, stream_export, write_export
from server.export.items import study_items
from server.settings import Settings
from server.store.engine import Database
from server.store.schema import SchemaMismatch
from server.store.tables import (
    Participant,
    Response,
    StaffNote,
    Trial,
    TrialEvent,
    TrialQuality,
    TrialRobot,
)
from study.config import Study
from study.errors import UnknownStudy
from study.files.demo import paper_study
from study.records.tables import TABLES, neutralise_formula
from tests.server.export.site import MakeResult, Site, export, read_tables

PRINTABLE = st.characters(exclude_categories=["Cs", "Cc"])
REMARKS = st.text(PRINTABLE, max_size=40) | st.sampled_from(
    ["=cmd|' /C calc'!A0", "@SUM(1)", '"quoted", and; more', "line\none", "-5", "naïve 🤖"]
)


ENDS = st.sampled_from(["", "", "withdrawn", "erased", "excluded"])


@pytest.fixture
def study() -> Study:
    """The demo study in the smallest hall, so that trials can be played."""
    return paper_study().revised(scale="practice")


@pytest.fixture
def site(database: Database, study: Study, make_result: MakeResult) -> Site:
    return Site(database, study, make_result)


async def read_bundle(database: Database, mode: str | None = None) -> dict[str, list[Any]]:
    return read_tables(await export(database, mode=mode, notes=True))


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
        notes = [n for n in await session.scalars(select(StaffNote)) if n.participant_id in kept]
    assert sorted(
        (r["participant_code"], r["trial_id"], r["tick"], r["text"]) for r in tables["notes"]
    ) == sorted(
        (
            people[n.participant_id].code,
            n.trial_id or "",
            "" if n.tick is None else str(n.tick),
            neutralise_formula(n.text),
        )
        for n in notes
    )
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
    assert {row["participant_code"] for row in tables["wide"]} == {p.code for p in kept.values()}
    told = sorted(
        (r["participant_code"], r["step"], r["item"], r["value"]) for r in tables["responses"]
    )
    assert told == sorted(
        (people[r.participant_id].code, r.step, r.item, neutralise_formula(r.value))
        for r in answers
    )


PEOPLE = st.lists(
    st.tuples(st.integers(0, 15), st.sampled_from("12345"), REMARKS, ENDS), max_size=3
)
People = list[tuple[int, str, str, str]]


async def add_people(url: str, people: People, study: Study, make_result: MakeResult) -> None:
    """Let them take part as far as told, then hold the export against the database."""
    database = Database(url)
    site = Site(database, study, make_result)
    await site.people.register_studies()
    for steps, rating, remark, end in people:
        token = await site.walk(steps, rating, remark)
        code = (await site.people.look_up(token)).participant.code
        await site.admin.note(code, remark.strip() or "=1+1", "maria")
        if end == "withdrawn":
            await site.people.withdraw(token)
        elif end == "erased":
            await site.staff.erase(code, "maria")
        elif end == "excluded":
            await site.staff.exclude(code, " ".join(remark.split()) or "none given", "maria")
    await check_export_equals_database(database)
    await database.close()


@given(people=PEOPLE)
@settings(
    max_examples=12, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
def test_the_export_equals_the_database(
    people: People,
    study: Study,
    make_result: MakeResult,
    tmp_path_factory: pytest.TempPathFactory,
    migrated_file: Path,
) -> None:
    """People who leave anywhere, withdraw or not, are excluded or erased, and write anything."""
    file = shutil.copy(migrated_file, tmp_path_factory.mktemp("export") / "a.sqlite3")
    asyncio.run(add_people(f"sqlite:///{file}", people, study, make_result))


@pytest.mark.postgres
@given(people=PEOPLE)
@settings(
    max_examples=6, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
def test_the_export_equals_the_database_on_postgresql(
    people: People, study: Study, make_result: MakeResult, postgres_migrated: str
) -> None:
    """Every example adds its people to those before."""
    asyncio.run(add_people(postgres_migrated, people, study, make_result))


async def test_a_whole_participation_on_each_kind_of_database(site: Site) -> None:
    await site.walk(15, "4", "=1+1")
    await check_export_equals_database(site.database)
    tables = await read_bundle(site.database)
    counts = [1, 3, 6, 9, 3 + 6 + 4 + 18 + 2, 0, 0, 0]
    assert [len(tables[name]) for name in TABLES] == counts
    (wide,) = tables["wide"]
    assert {wide[f"questionnaire_Q1_{name}"] for name in order_of(tables)} == {"4"}
    assert {wide[f"sum_wait_s_{name}"] for name in order_of(tables)} == {"22.0"}
    assert wide["comments_remarks"] == "'=1+1"
    order = order_of(tables)
    assert [row["condition"] for row in tables["trials"]] == order
    ratings = [row for row in tables["responses"] if row["instrument"] == "questionnaire"]
    assert {(row["position"], row["condition"]) for row in ratings} == {
        (str(k), name) for k, name in enumerate(order, 1)
    }
    assert {row["label"] for row in ratings} == {"Somewhat agree"}
    assert {row["value"] for row in tables["responses"] if row["item"] == "remarks"} == {"'=1+1"}


def order_of(tables: dict[str, Any]) -> list[str]:
    order: str = tables["participants"][0]["condition_order"]
    return order.split(">")


async def test_a_played_trial_comes_with_its_events_and_quality(site: Site) -> None:
    """Events as they are stored, field by field, and the figures of the room."""
    token = await site.walk(6, "4", "")
    trial_id = await site.play(token)
    tables = await read_bundle(site.database)
    async with site.database.reading() as session:
        stored = await session.scalars(select(TrialEvent).where(TrialEvent.trial_id == trial_id))
        events = {str(e.number): (str(e.tick), e.kind, e.data) for e in stored}
        quality = (await session.scalars(select(TrialQuality))).one()
    assert len(events) > 10
    assert {
        row["number"]: (row["tick"], row["kind"], json.loads(row["data"]))
        for row in tables["events"]
    } == events
    assert {row["trial_id"] for row in tables["events"]} == {trial_id}
    (row,) = tables["quality"]
    assert (row["trial_id"], row["connections"], row["reports"]) == (trial_id, "1", "0")
    assert (row["idle_s"], row["rtt_median_ms"]) == (repr(quality.idle_s), "")


async def test_notes_come_with_their_moments_and_without_their_writers(site: Site) -> None:
    """About the participant, the practice and a trial, in the order written, formulas tamed; a
    moment after a trial's last tick is its last."""
    token = await site.walk(8, "4", "")
    code = (await site.people.look_up(token)).participant.code
    async with site.database.reading() as session:
        trials = {t.step: t.id for t in await session.scalars(select(Trial))}
    await site.admin.note_trial(trials["trial-1"], 301, "stands still", "maria")
    await site.admin.note(code, "=SUM(A1)", "nora")
    await site.admin.note_trial(trials["practice"], 10**8, "lost the pointer", "maria")
    rows = (await read_bundle(site.database))["notes"]
    wanted = ("number", "trial_id", "step", "tick", "time_s", "text")
    assert [tuple(row[name] for name in wanted) for row in rows] == [
        ("0", trials["trial-1"], "trial-1", "301", "10.033", "stands still"),
        ("1", "", "", "", "", "'=SUM(A1)"),
        ("2", trials["practice"], "practice", "3000", "100.0", "lost the pointer"),
    ]
    assert {row["participant_code"] for row in rows} == {code}
    async with site.database.reading() as session:
        stored = [n.at for n in await session.scalars(select(StaffNote).order_by(StaffNote.id))]
    assert [row["written_at"][:19] for row in rows] == [
        at.isoformat(timespec="seconds")[:19] for at in stored
    ]
    whole = await export(site.database)
    with zipfile.ZipFile(io.BytesIO(whole)) as bundle:
        text = b"".join(bundle.read(name) for name in bundle.namelist())
    assert b"maria" not in text
    assert b"nora" not in text


async def test_nothing_in_the_export_leads_back_to_a_person(site: Site) -> None:
    token = await site.walk(15, "4", "")
    pieces = [piece async for piece in stream_export(site.database, ExportOptions("demo"))]
    with zipfile.ZipFile(io.BytesIO(b"".join(pieces))) as bundle:
        whole = b"".join(bundle.read(name) for name in bundle.namelist())
    assert token.encode() not in whole
    assert b"panel-id" not in whole
    asked_for = read_tables(await export(site.database, panel_ids=True))
    assert [row["value"][:9] for row in asked_for["panel_ids"]] == ["panel-id-"]
    assert "notes" not in asked_for


async def test_columns_do_not_depend_on_what_was_answered(site: Site) -> None:
    await site.people.register_studies()
    pieces = [piece async for piece in stream_export(site.database, ExportOptions("demo"))]
    with zipfile.ZipFile(io.BytesIO(b"".join(pieces))) as bundle:
        for table in TABLES.values():
            assert bundle.read(table.file).decode() == ",".join(table.header) + "\n"
        header = bundle.read("wide.csv").decode().strip().split(",")
    assert {"questionnaire_Q6_crmiar", "sum_wait_s_varil", "demographics_age"} <= set(header)


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
        await anext(stream_export(database, ExportOptions("nope")))


async def test_a_file_appears_only_when_it_is_complete(site: Site, tmp_path: Path) -> None:
    await site.walk(15, "4", "")
    config, out = Settings(database_url=site.database.url), tmp_path / "out.zip"
    if site.database.file is None:
        config = Settings(database_url=site.database.url.replace("+asyncpg", ""))
    assert (await write_export(config, ExportOptions("demo"), out))["trials"] == 3
    with pytest.raises(UnknownStudy):
        await write_export(config, ExportOptions("nope"), tmp_path / "none.zip")
    assert [file.name for file in tmp_path.iterdir() if ".zip" in file.name] == ["out.zip"]


async def test_an_export_from_another_schema_is_refused(tmp_path: Path) -> None:
    empty = Settings(var_dir=tmp_path)
    with pytest.raises(SchemaMismatch, match="varil migrate"):
        await write_export(empty, ExportOptions("demo"), tmp_path / "a.zip")
