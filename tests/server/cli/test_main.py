"""Guards the command: every failure is one sentence that says what to do, and an exit code."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from server.cli.main import app, run_command

VARIL = Path(sys.executable).parent / "varil"


def call(*words: str, **variables: str) -> subprocess.CompletedProcess[str]:
    """Run `varil` in a process of its own."""
    return subprocess.run(
        [str(VARIL), *words],
        env={**os.environ, **variables},
        capture_output=True,
        text=True,
        timeout=60,
    )


def complaint(words: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[int, str]:
    """Exit code and stderr of a call within this process."""
    code = run_command(lambda **options: app(words, **options))
    return code, capsys.readouterr().err


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A data folder of its own for calls within this process."""
    monkeypatch.setenv("VARIL_VAR_DIR", str(tmp_path / "var"))
    return tmp_path


def test_an_unknown_study_is_told_to_the_operator(here: Path, capsys) -> None:
    assert complaint(["migrate"], capsys)[0] == 0
    code, said = complaint(["export", "--study", "nope", "--out", str(here / "x.zip")], capsys)
    assert code == 1
    assert "no study “nope” in this database" in said
    assert not (here / "x.zip").exists()


def test_a_reading_verb_makes_no_database(here: Path, capsys) -> None:
    code, said = complaint(["export", "--study", "demo", "--out", str(here / "x.zip")], capsys)
    assert code == 1
    assert "there is no database at" in said
    assert not (here / "var").exists()


def test_a_file_that_is_no_database_is_named_and_left_alone(here: Path, capsys) -> None:
    file = here / "notes.txt"
    file.write_text("not a database, " * 200)
    code, said = complaint(["migrate", "--database-url", f"sqlite:///{file}"], capsys)
    assert code == 1
    assert "holds something else" in said
    assert file.read_text().startswith("not a database")


def test_an_output_folder_that_cannot_be_made_is_named(here: Path, capsys) -> None:
    (here / "taken").write_text("")
    words = ["simulate", "--scale", "practice", "--trials", "1", "--out", str(here / "taken" / "x")]
    code, said = complaint(words, capsys)
    assert code == 1
    assert "taken" in said
    assert "Choose another place" in said


def test_a_policy_without_its_condition_is_a_wrong_call(here: Path, capsys) -> None:
    words = ["simulate", "--condition", "none", "--policy", "p.json", "--out", str(here)]
    code, said = complaint(words, capsys)
    assert code == 2
    assert "follows no policy" in said


@pytest.mark.parametrize(
    ("variable", "value", "code", "sentence"),
    [
        ("VARIL_PORT", "99999", 2, "VARIL_PORT"),
        ("VARIL_TIME_SCALE", "9", 2, "VARIL_TIME_SCALE"),
        ("VARIL_ADMIN_PASSWORD", "short", 2, "VARIL_ADMIN_PASSWORD"),
        ("VARIL_ALLOWED_ORIGINS", "https://a.example", 1, "Lists are written as JSON"),
        ("VARIL_DATABASE_URL", "mysql://h/x", 1, "sqlite:///path/to/file"),
    ],
)
def test_a_wrong_setting_is_named(
    here: Path, capsys, monkeypatch, variable: str, value: str, code: int, sentence: str
) -> None:
    monkeypatch.setenv(variable, value)
    found, said = complaint(["migrate"], capsys)
    assert found == code
    assert sentence in said


def test_an_empty_key_file_is_refused_with_what_to_do(here: Path, capsys) -> None:
    (here / "var").mkdir()
    (here / "var/secret_key").write_text("")
    code, said = complaint(["serve", "--port", "0"], capsys)
    assert code == 1
    assert "Delete it to have a new one made" in said


def test_a_port_in_use_stops_the_start(here: Path) -> None:
    """The first process keeps the port; the second says which one and touches no database."""
    import socket

    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        done = call("serve", "--port", port, VARIL_VAR_DIR=str(here / "other"))
    assert done.returncode == 1
    assert f"127.0.0.1:{port}" in done.stderr
    assert "--port" in done.stderr
    assert not (here / "other").exists()


def test_a_wrong_verb_is_a_wrong_call() -> None:
    assert call("dance").returncode == 2


def test_a_participant_is_erased_once_and_what_is_kept_is_told(here: Path, capsys) -> None:
    import asyncio
    import json

    from server.settings import Settings
    from server.store.bench_people import add_bench_people
    from server.store.engine import Database
    from study.files.demo import paper_study

    assert complaint(["migrate"], capsys)[0] == 0

    async def fill() -> None:
        database = Database(Settings().database)
        await add_bench_people(database, paper_study(), 2)
        await database.close()

    asyncio.run(fill())
    assert run_command(lambda **options: app(["erase", "p-b0000001", "--json"], **options)) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["participant"], told["trials"], told["trial_robots"]) == ("P-B0000001", 3, 36)
    assert "the participant code" in told["kept"]
    code, said = complaint(["erase", "P-B0000001"], capsys)
    assert (code, "were erased before" in said) == (1, True)
    code, said = complaint(["erase", "P-NOBODY"], capsys)
    assert (code, "no participant “P-NOBODY”" in said) == (1, True)


def test_an_account_is_added_then_renewed(here: Path, capsys, monkeypatch) -> None:
    import io

    words = ["user", "add", "maria", "--role", "expert", "--password-stdin"]
    for said in ("Added", "Renewed"):
        monkeypatch.setattr("sys.stdin", io.StringIO("a-long-password\n"))
        assert run_command(lambda **options: app(words, **options)) == 0
        assert f"{said} maria as expert" in capsys.readouterr().out
