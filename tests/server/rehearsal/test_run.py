"""Guards a whole rehearsal: six simulated participants on a fresh server, up to the report."""

from __future__ import annotations

import asyncio
import csv
import io
import socket
import zipfile
from collections import Counter
from collections.abc import AsyncIterator
from pathlib import Path

import frictionless
import pytest
import uvicorn

from server.app import create_app
from server.desks.accounts import add_user
from server.live.line import LineProtocol
from server.rehearsal.run import RehearsalOptions, cast_roles, find_study, rehearse
from server.rehearsal.site import Site, SiteError
from server.settings import Settings
from server.store.engine import Database
from server.store.schema import migrate
from study.config import Study
from study.errors import InvalidValue
from tests.server.analysis.recomputed import check_analysis

PASSWORD = "rehearse-me-now"


@pytest.fixture
async def url(settings: Settings, study: Study) -> AsyncIterator[str]:
    """Address of a running server with the demo study in the smallest hall."""
    database = Database(settings.database)
    await migrate(database)
    await add_user(database, "admin", "admin", PASSWORD)
    await database.close()
    app = create_app(settings, [study.revised(scale=("practice",))])
    listener = socket.create_server(("127.0.0.1", 0))
    config = uvicorn.Config(app, ws=LineProtocol, ws_per_message_deflate=False, log_config=None)
    server = uvicorn.Server(config)
    running = asyncio.create_task(server.serve(sockets=[listener]))
    yield f"http://127.0.0.1:{listener.getsockname()[1]}"
    server.should_exit = True
    await running


async def test_six_take_part_up_to_the_report(url: str, tmp_path: Path) -> None:
    """One drops out, one withdraws, some reload and answer late: every check is green, the zip
    says the same to those who know nothing of us, and the report's numbers follow from it."""
    options = RehearsalOptions(url, 6, 3, tmp_path / "out", dropout=0.17, withdraw=0.17)
    site = Site(url)
    with pytest.raises(SiteError):
        await site.sign_in("admin", "not the password")
    await site.sign_in("admin", PASSWORD)
    outcome = await rehearse(options, site, lambda line: None)
    told = outcome.to_json()
    assert told["problems"] == []
    assert [check for check in told["checks"] if not check["passed"]] == []
    assert (told["participants"], told["completed"], told["dropped"]) == (6, 4, 2)
    with zipfile.ZipFile(options.out / "rehearsal.zip") as bundle:
        bundle.extractall(tmp_path / "bundle")
        people = _read(bundle, "participants.csv")
        trials = _read(bundle, "trials.csv")
    assert Counter(row["status"] for row in people) == {
        "completed": 4,
        "timed-out": 1,
        "withdrawn": 1,
    }
    done = {row["participant_code"] for row in people if row["status"] == "completed"}
    assert Counter(
        row["participant_code"] for row in trials if row["participant_code"] in done
    ) == (dict.fromkeys(done, 3))
    report = frictionless.validate(str(tmp_path / "bundle" / "datapackage.json"))
    assert report.valid, report.flatten(["type", "message"])
    assert (options.out / "report" / "report.html").stat().st_size > 10_000
    facts = check_analysis(options.out / "rehearsal.zip", options.out / "report")
    assert set(facts.cases("sum_wait_s")["participant_code"]) == done


def test_roles_follow_the_seed_and_the_shares() -> None:
    """Those who leave first; the same seed gives the same roles, another one others."""
    options = RehearsalOptions("http://x", 60, 5, Path("out"), dropout=0.1, withdraw=0.05)
    roles = cast_roles(options)
    fates = [role.fate for role in roles]
    assert fates == ["drops"] * 6 + ["withdraws"] * 3 + ["stays"] * 51
    assert sum(role.reloads for role in roles) == 12
    assert cast_roles(options) == roles
    assert cast_roles(RehearsalOptions("http://x", 60, 6, Path("out"))) != roles


@pytest.mark.parametrize(
    ("known", "wanted", "told"),
    [
        (["a"], "", "a"),
        (["a", "b"], "b", "b"),
        (["a", "b"], "", "has several studies. Name one with --study: a, b."),
        (["a", "b"], "c", "has no study “c”. Name one with --study: a, b."),
        ([], "", "has no study. Start the server with one: varil serve --study FILE."),
    ],
)
async def test_the_only_study_need_not_be_named(
    known: list[str], wanted: str, told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The error tells the names there are."""

    async def answer(site: Site, path: str) -> list[dict[str, str]]:
        assert path == "/api/v1/studies"
        return [{"study_id": name} for name in known]

    monkeypatch.setattr(Site, "read_json", answer)
    try:
        found = await find_study(Site("http://x"), wanted)
    except InvalidValue as error:
        found = error.sentence
    assert found.endswith(told)


def _read(bundle: zipfile.ZipFile, name: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(bundle.read(name).decode(), newline="")))
