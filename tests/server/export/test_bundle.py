"""Guards the bundle: plain frictionless accepts it, it is cut off noticeably, never in between."""

from __future__ import annotations

import csv
import gzip
import hashlib
import io
import itertools
import json
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import select, text

from server.export.bundle import ExportOptions, stream_export, write_export
from server.settings import Settings
from server.store.engine import Database
from server.store.tables import StoredPolicy, Trial
from study.config import Study
from study.files.demo import paper_study
from study.records.columns import ORIGIN
from tests.server.export.site import MakeResult, Site, export, read_tables

FRICTIONLESS = Path(sys.executable).parent / "frictionless"


@pytest.fixture
def study() -> Study:
    """The demo study in the smallest hall, so that trials can be played."""
    return paper_study().revised(scale="practice")


@pytest.fixture
async def site(tmp_path: Path, study: Study, make_result: MakeResult, migrated_file: Path) -> Any:
    database = Database(f"sqlite:///{shutil.copy(migrated_file, tmp_path / 'a.sqlite3')}")
    site = Site(database, study, make_result)
    await site.people.register_studies()
    yield site
    await database.close()


async def fill(site: Site) -> str:
    """One who played, one who typed a formula, one who withdrew, one erased; notes about all."""
    token = await site.walk(6, "4", "")
    trial_id = await site.play(token)
    await site.admin.note_trial(trial_id, 90, "+1 for walking", "m")
    await site.walk(15, "5", "=HYPERLINK(1)\nand a second line, with a comma")
    for end in ("withdraw", "erase"):
        other = await site.walk(8, "1", "")
        code = (await site.people.look_up(other)).participant.code
        await site.admin.note(code, "asked for a pause", "m")
        await (site.people.withdraw(other) if end == "withdraw" else site.staff.erase(code, "m"))
    return trial_id


def judge(bundle: Path) -> dict[str, Any]:
    """What the command `frictionless validate` says."""
    done = subprocess.run(
        [FRICTIONLESS, "validate", "--json", bundle.name],
        capture_output=True,
        text=True,
        cwd=bundle.parent,
    )
    report: dict[str, Any] = json.loads(done.stdout)
    return report


async def test_frictionless_accepts_the_bundle_with_everything_in_it(
    site: Site, tmp_path: Path
) -> None:
    """Unpacked, with every size, hash, type, key and reference; and it names what is spoilt."""
    await fill(site)
    folder = tmp_path / "bundle"
    with zipfile.ZipFile(
        io.BytesIO(await export(site.database, telemetry=True, panel_ids=True, notes=True))
    ) as bundle:
        bundle.extractall(folder)
    report = judge(folder / "datapackage.json")
    assert report["valid"], report
    names = {task["name"] for task in report["tasks"]}
    assert {"wide", "events", "quality", "expert_labels", "notes", "codebook"} <= names
    assert "panel_ids" in names
    assert any(name.startswith("telemetry/") for name in names)
    quality = folder / "quality.csv"
    quality.write_text(quality.read_text().replace(",practice,", ",elsewhere,") + "x\n")
    assert not judge(folder / "datapackage.json")["valid"]


async def test_an_empty_study_is_a_valid_bundle_too(site: Site, tmp_path: Path) -> None:
    with zipfile.ZipFile(io.BytesIO(await export(site.database))) as bundle:
        bundle.extractall(tmp_path / "bundle")
    report = judge(tmp_path / "bundle" / "datapackage.json")
    assert report["valid"], report


async def test_policies_are_files_named_by_their_hash(site: Site) -> None:
    await fill(site)
    async with site.database.reading() as session:
        stored = {row.sha256: row.document for row in await session.scalars(select(StoredPolicy))}
    with zipfile.ZipFile(io.BytesIO(await export(site.database))) as bundle:
        files = [name for name in bundle.namelist() if name.startswith("policies/")]
        assert files
        for name in files:
            assert bundle.read(name).decode() == stored[Path(name).stem]


async def test_telemetry_is_where_the_person_was_five_times_a_second(site: Site) -> None:
    trial_id = await fill(site)
    data = await export(site.database, telemetry=True)
    (trial,) = [row for row in read_tables(data)["trials"] if row["trial_id"] == trial_id]
    with zipfile.ZipFile(io.BytesIO(data)) as bundle:
        packed = bundle.read(f"telemetry/{trial_id}.csv.gz")
        told = bundle.read("README.txt").decode()
    rows = list(csv.DictReader(io.StringIO(gzip.decompress(packed).decode())))
    ticks = [int(row["tick"]) for row in rows]
    assert ticks == list(range(0, int(trial["ticks"]) + 1, 6))
    steps = itertools.pairwise(rows)
    path_m = sum(
        ((float(b["x_m"]) - float(a["x_m"])) ** 2 + (float(b["y_m"]) - float(a["y_m"])) ** 2) ** 0.5
        for a, b in steps
    )
    assert path_m == pytest.approx(float(trial["human_path_m"]), rel=0.1)
    assert f"- {trial_id}:" not in told
    assert told.count("no inputs of it are stored") == 3, "those that only ended, never played"


async def test_a_damaged_journal_costs_only_its_own_telemetry(site: Site) -> None:
    trial_id = await fill(site)
    async with site.database.writing() as session:
        await session.execute(
            text("UPDATE trial_chunks SET hashes = x'1E0000000000000000000000' WHERE first_tick=1")
        )
    with zipfile.ZipFile(io.BytesIO(await export(site.database, telemetry=True))) as bundle:
        assert not [name for name in bundle.namelist() if trial_id in name]
        assert f"- {trial_id}: the replayed state differs" in bundle.read("README.txt").decode()


async def test_a_lost_end_of_a_journal_is_named(site: Site) -> None:
    trial_id = await fill(site)
    last = "(SELECT max(first_tick) FROM trial_chunks)"
    async with site.database.writing() as session:
        await session.execute(text(f"DELETE FROM trial_chunks WHERE first_tick = {last}"))
    with zipfile.ZipFile(io.BytesIO(await export(site.database, telemetry=True))) as bundle:
        told = bundle.read("README.txt").decode()
    assert f"- {trial_id}: its stored inputs end at tick" in told


async def test_the_manifest_holds_every_file_but_itself(site: Site) -> None:
    await fill(site)
    with zipfile.ZipFile(io.BytesIO(await export(site.database, telemetry=True))) as bundle:
        lines = bundle.read("MANIFEST.sha256").decode().splitlines()
        found = {name: digest for digest, name in (line.split("  ") for line in lines)}
        assert set(found) == set(bundle.namelist()) - {"MANIFEST.sha256"}
        for name, digest in found.items():
            assert hashlib.sha256(bundle.read(name)).hexdigest() == digest


@pytest.mark.parametrize("share", [0.0, 0.3, 0.7, 0.999])
async def test_a_download_cut_off_anywhere_is_no_zip(site: Site, share: float) -> None:
    await fill(site)
    whole = await export(site.database)
    with pytest.raises(zipfile.BadZipFile):
        zipfile.ZipFile(io.BytesIO(whole[: int(len(whole) * share)]))


async def test_an_interrupted_export_lets_go_of_the_database_and_leaves_no_file(
    site: Site, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    await fill(site)
    monkeypatch.setattr("server.export.bundle.YIELD_BYTES", 1)
    stream = stream_export(site.database, ExportOptions("demo"))
    await anext(stream)
    await stream.aclose()
    assert site.database.engine.pool.checkedout() == 0  # type: ignore[attr-defined]

    def fail(*anything: object) -> None:
        raise RuntimeError("cut off")

    monkeypatch.setattr("server.export.bundle.make_readme", fail)
    with pytest.raises(RuntimeError, match="cut off"):
        await write_export(
            Settings(database_url=f"sqlite:///{site.database.file}"),
            ExportOptions("demo"),
            tmp_path / "x.zip",
        )
    assert not list(tmp_path.glob("x.zip*"))


async def test_an_export_taken_while_people_go_on_is_of_one_moment(
    site: Site, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is stored after its first row is in no later table."""
    token = await site.walk(8, "4", "")
    monkeypatch.setattr("server.export.bundle.YIELD_BYTES", 1)
    pieces = []
    async for piece in stream_export(site.database, ExportOptions("demo")):
        if not pieces:
            await site.walk(15, "5", "")
            await site.people.withdraw(token)
        pieces.append(piece)
    tables = read_tables(b"".join(pieces))
    assert (len(tables["participants"]), len(tables["trials"])) == (1, 1)
    assert {row["step"] for row in tables["responses"]} == {
        "consent",
        "browser-check",
        "demographics",
        "questionnaire-1",
    }
    assert [row["status"] for row in tables["wide"]] == ["active"]


async def test_every_row_of_every_table_says_where_it_comes_from(site: Site) -> None:
    await fill(site)
    tables = read_tables(await export(site.database, panel_ids=True))
    names = [column.name for column in ORIGIN]
    for name, rows in tables.items():
        if name not in ("codebook", "expert_labels"):
            assert rows, name
            for row in rows:
                assert all(row[column] for column in names), name


async def test_an_open_trial_is_exported_as_such(site: Site) -> None:
    token = await site.walk(6, "4", "")
    await site.desk.open_trial(token)
    tables = read_tables(await export(site.database, telemetry=True))
    assert [row["status"] for row in tables["trials"]] == ["open"]
    async with site.database.reading() as session:
        assert len(list(await session.scalars(select(Trial)))) == 2
