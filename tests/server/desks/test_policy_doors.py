"""Guards the doors through which a policy comes: each refuses a bad one, and names the fault."""

from __future__ import annotations

import html
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from fastapi import FastAPI
from starlette.testclient import TestClient

from server.cli.main import app as cli
from server.cli.main import run_command
from server.desks.policies import PolicyDesk
from server.policy_files import shipped_policy
from server.store.engine import Database
from server.store.policies import keep_policy
from study.ar.thresholds import Thresholds
from study.config import Study
from tests.server.bad_policies import BAD_FILES, make_policy

SignIn = Callable[[str], TestClient]


def send(client: TestClient, data: bytes, page: str = "/admin/policies") -> Any:
    return client.post(page, files={"file": ("policy.json", data, "application/json")})


async def count_policies(database: Database) -> int:
    desk = PolicyDesk(database, {})
    return (await desk.list_policies(offset=0, limit=1))[1]


@pytest.mark.parametrize("name", BAD_FILES)
def test_an_upload_is_refused_with_its_fault(sign_in_as: SignIn, app: FastAPI, name: str) -> None:
    """The page comes back with the sentence, and nothing is stored."""
    client, (data, sentence) = sign_in_as("admin"), BAD_FILES[name]
    answer = send(client, data)
    assert answer.status_code == 422
    assert sentence.lower() in html.unescape(answer.text).lower()
    assert client.portal is not None
    database = app.state.services.database
    assert client.portal.call(count_policies, database) == 1, "the shipped one alone"


def test_an_upload_of_10_mb_or_of_nothing_is_refused(sign_in_as: SignIn) -> None:
    client = sign_in_as("admin")
    huge = send(client, b" " * 10_000_000)
    assert (huge.status_code, "64 kB" in huge.text) == (413, True)
    for answer in (send(client, b""), client.post("/admin/policies")):
        assert (answer.status_code, "the file is empty" in answer.text.lower()) == (422, True)


@pytest.mark.parametrize("name", [*BAD_FILES, "10 MB"])
def test_the_command_refuses_a_file_with_its_fault(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    """`varil simulate --policy`: exit code 1, the sentence on stderr, and no output folder."""
    data, sentence = BAD_FILES.get(name, (b" " * 10_000_000, "larger than"))
    file, out = tmp_path / "policy.json", tmp_path / "out"
    file.write_bytes(data)
    words = ["simulate", "--condition", "varil", "--policy", str(file), "--out", str(out)]
    assert run_command(lambda **options: cli(words, **options)) == 1
    assert sentence in capsys.readouterr().err
    assert not out.exists()


@pytest.mark.parametrize(
    ("form", "status", "told"),
    [
        ({"study": "demo"}, 422, "close_m 4.0 (study: 5.0)"),
        ({"study": "nope"}, 422, "no study “nope”"),
        ({}, 422, "no study"),
    ],
)
def test_an_activation_that_does_not_fit_is_refused(
    sign_in_as: SignIn, app: FastAPI, form: dict[str, str], status: int, told: str
) -> None:
    """A policy for other borders can be stored by a run; no study here may run it."""
    client, services = sign_in_as("admin"), app.state.services
    other = replace(make_policy("other"), thresholds=Thresholds(close_m=4.0))

    async def store() -> None:
        async with services.database.writing() as session:
            await keep_policy(session, other, "run", datetime.now(UTC))

    assert client.portal is not None
    client.portal.call(store)
    answer = client.post(f"/admin/policies/{other.sha256}/activate", data=form)
    assert (answer.status_code, told in answer.text) == (status, True)
    active = client.portal.call(services.policies.find_active, services.policies.studies["demo"])
    assert (active.policy, active.chosen) == (shipped_policy(), False)


@pytest.mark.parametrize("sha256", ["0" * 64, "nonsense", "%00", "A" * 64])
def test_a_policy_that_is_not_here_is_not_found(sign_in_as: SignIn, sha256: str) -> None:
    client = sign_in_as("admin")
    for page in ("", "/file.json", f"?compare={sha256}"):
        assert client.get(f"/admin/policies/{sha256}{page}").status_code == 404
    answer = client.post(f"/admin/policies/{sha256}/activate", data={"study": "demo"})
    assert answer.status_code == 404


async def test_starting_with_a_live_study_and_a_simulated_policy_warns(
    database: Database, study: Study, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also when it is the shipped one; pilots are not warned about."""
    simulated, people = make_policy("bred"), make_policy("taught", "people")
    monkeypatch.setattr("server.desks.policies.shipped_policy", lambda: simulated)
    pilots = PolicyDesk(database, {"demo": study})
    live = PolicyDesk(database, {"demo": study.revised(recruiting="live")})
    plain = study.revised(recruiting="live", conditions=("arroch",))
    assert await pilots.list_warnings() == []
    assert await PolicyDesk(database, {"demo": plain}).list_warnings() == []
    (warning,) = await live.list_warnings()
    assert "“demo” recruits live" in warning
    assert "“bred” was learned from simulated people" in warning
    await live.upload(people.to_json().encode(), "ann")
    await live.activate(people.sha256, "demo", "ann", confirmed=False)
    assert await live.list_warnings() == []
    moved = study.revised(thresholds={"close_m": 4.0})
    (warning,) = await PolicyDesk(database, {"demo": moved}).list_warnings()
    assert "close_m 5.0 (study: 4.0)" in warning


async def test_serve_says_the_warning_before_it_serves(
    tmp_path: Path,
    study: Study,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    from server.serving import _prepare
    from server.settings import Settings
    from server.study_files import ReadStudy

    monkeypatch.setattr("server.desks.policies.shipped_policy", lambda: make_policy("bred"))
    config = Settings(var_dir=tmp_path, admin_password="long enough for tests")  # type: ignore[arg-type]
    await _prepare(config, [ReadStudy(study.revised(recruiting="live"))])
    said = capsys.readouterr().out
    assert "Warning: the study “demo” recruits live participants" in said
