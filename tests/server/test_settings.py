"""Guards secrets: none has a default, the key file is private, nothing is printed."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest
from pydantic import ValidationError
from starlette.testclient import TestClient

from server.app import create_app
from server.pages.rendering import Assets, MissingAssets
from server.settings import Settings
from server.store.engine import DatabaseInUse
from server.store.schema import SchemaMismatch
from study.config import Study
from study.errors import InvalidValue, NotAllowedLive


def test_the_key_is_made_once_and_private(tmp_path: Path) -> None:
    settings = Settings(var_dir=tmp_path / "var")
    first = settings.read_secret_key()
    assert first == settings.read_secret_key()
    assert len(first) >= 32
    assert stat.S_IMODE((tmp_path / "var/secret_key").stat().st_mode) == 0o600
    assert Settings(var_dir=tmp_path / "other").read_secret_key() != first


def test_an_empty_key_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "secret_key").touch()
    with pytest.raises(InvalidValue, match="Delete it"):
        Settings(var_dir=tmp_path).read_secret_key()


def test_settings_come_from_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VARIL_PORT", "9001")
    monkeypatch.setenv("VARIL_SECRET_KEY", "s" * 40)
    monkeypatch.setenv("VARIL_DATABASE_URL", "postgresql://h/n")
    settings = Settings()
    assert (settings.port, settings.database) == (9001, "postgresql://h/n")
    assert settings.read_secret_key() == b"s" * 40
    assert "sss" not in repr(settings)


@pytest.mark.parametrize(
    ("name", "value"),
    [("PORT", "70000"), ("PORT", "x"), ("TIME_SCALE", "5"), ("TIME_SCALE", "0.5"),
     ("SECRET_KEY", "short")],
)  # fmt: skip
def test_a_wrong_setting_is_refused(monkeypatch: pytest.MonkeyPatch, name: str, value: str) -> None:
    monkeypatch.setenv(f"VARIL_{name}", value)
    with pytest.raises(ValidationError, match=name.lower()):
        Settings()


def test_a_time_scale_is_refused_where_live_participants_are_recruited(
    study: Study, tmp_path: Path
) -> None:
    fast = Settings(var_dir=tmp_path, time_scale=4.0)
    create_app(fast, [study])
    with pytest.raises(NotAllowedLive):
        create_app(fast, [study.revised(recruiting="live")])


def test_a_second_server_on_the_same_file_does_not_start(
    client: TestClient, settings: Settings, study: Study
) -> None:
    assert client.get("/healthz").status_code == 200
    with (
        pytest.raises(DatabaseInUse, match="another server"),
        TestClient(create_app(settings, [study])),
    ):
        pass
    assert client.get("/readyz").status_code == 200


def test_a_server_does_not_start_on_another_schema(settings: Settings, study: Study) -> None:
    with (
        pytest.raises(SchemaMismatch, match="varil migrate"),
        TestClient(create_app(settings, [study])),
    ):
        pass


def test_missing_assets_name_the_command(tmp_path: Path) -> None:
    with pytest.raises(MissingAssets, match="make install"):
        Assets(tmp_path).check()


def test_an_asset_has_a_new_address_when_it_changes(tmp_path: Path) -> None:
    assets, file = Assets(tmp_path), tmp_path / "a.js"
    file.write_text("1")
    first = assets.address("a.js")
    assert first.startswith("/static/a.js?v=")
    assert assets.address("a.js") == first
    file.write_text("22")
    os.utime(file, (1, 1))
    assert assets.address("a.js") != first
