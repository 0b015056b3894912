"""Guards `varil doctor`: all green where all is well, and a red line with advice for each fault."""

from __future__ import annotations

import json
import shutil
import socket
from pathlib import Path

import pytest

from server.cli.main import app, run_command
from server.health import Check, examine
from server.settings import Settings


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def find(settings: Settings, name: str) -> Check:
    (check,) = [check for check in examine(settings) if check.name == name]
    return check


def test_a_sound_installation_is_green(settings: Settings) -> None:
    checks = examine(settings.model_copy(update={"port": free_port()}))
    assert [check for check in checks if not check.is_well] == []
    assert not settings.var_dir.exists(), "nothing is made by looking"


def test_a_port_held_by_something_else_is_red(settings: Settings) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        held = settings.model_copy(update={"port": taken.getsockname()[1]})
        check = find(held, "port")
    assert not check.is_well
    assert "--port" in check.next_step


def test_an_old_schema_and_a_foreign_file_are_red(settings: Settings, tmp_path: Path) -> None:
    import sqlite3

    old = tmp_path / "old.sqlite3"
    with sqlite3.connect(old) as connection:
        connection.execute("CREATE TABLE alembic_version (version_num TEXT)")
        connection.execute("INSERT INTO alembic_version VALUES ('0001')")
    check = find(settings.model_copy(update={"database_url": f"sqlite:///{old}"}), "database")
    assert not check.is_well
    assert "schema 0001, this software needs" in check.found
    assert "varil migrate" in check.next_step
    old.write_text("not a database, " * 200)
    check = find(settings.model_copy(update={"database_url": f"sqlite:///{old}"}), "database")
    assert not check.is_well
    assert "holds something else" in check.found


def test_a_database_that_is_away_is_red(settings: Settings) -> None:
    away = settings.model_copy(update={"database_url": "postgresql://nobody@127.0.0.1:1/none"})
    check = find(away, "database")
    assert (check.is_well, "does not answer" in check.found) == (False, True)


def test_a_full_disk_and_a_missing_client_are_red(
    settings: Settings, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    usage = shutil.disk_usage(tmp_path)._replace(free=3_000_000)
    monkeypatch.setattr(shutil, "disk_usage", lambda place: usage)
    monkeypatch.setattr("server.health.web_root", lambda: tmp_path)
    assert "3 MB free" in find(settings, "free disk").found
    assert find(settings, "browser client").next_step == "Run `make install`."


def test_a_folder_that_cannot_be_written_is_red(settings: Settings, tmp_path: Path) -> None:
    """A file stands where the folder should be made: nobody may write there, root included."""
    (tmp_path / "taken").write_text("")
    blocked = settings.model_copy(update={"var_dir": tmp_path / "taken"})
    assert not find(blocked, "data folder").is_well


def test_the_verb_tells_it_in_json_and_by_its_exit_code(
    settings: Settings, tmp_path: Path, capsys, monkeypatch
) -> None:
    monkeypatch.setenv("VARIL_VAR_DIR", str(tmp_path / "var"))
    monkeypatch.setenv("VARIL_PORT", str(free_port()))
    assert run_command(lambda **options: app(["doctor", "--json"], **options)) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["ok"]
    assert {"name", "ok", "found", "next_step"} == set(found["checks"][0])
    monkeypatch.setenv("VARIL_DATABASE_URL", "postgresql://nobody@127.0.0.1:1/none")
    assert run_command(lambda **options: app(["doctor"], **options)) == 1
    assert "FAIL" in capsys.readouterr().out
