"""Fixtures for the whole suite: a study, databases of both kinds, the app and its client."""

from __future__ import annotations

import asyncio
import os
import shutil
import uuid
from collections.abc import AsyncIterator, Iterator
from pathlib import Path

import pytest
from fastapi import FastAPI
from sqlalchemy import text
from sqlalchemy.ext.asyncio import create_async_engine
from starlette.testclient import TestClient

from server.app import create_app
from server.kernel_cache import use_kernel_cache
from server.settings import Settings
from server.store.engine import Database
from server.store.schema import migrate
from study.config import Study
from study.files.demo import paper_study
from tests.postgres import PostgresServer, find_programs

# Compiled code is kept between runs and shared by the whole suite, its subprocesses included.
KERNELS = Path(__file__).parent.parent / "var" / "kernels"
os.environ["VARIL_CACHE_DIR"] = str(KERNELS)
use_kernel_cache(KERNELS)


@pytest.fixture
def study() -> Study:
    """The demo study."""
    return paper_study()


@pytest.fixture
def settings(tmp_path: Path) -> Settings:
    """Settings of a server that keeps everything in the test's own folder."""
    return Settings(var_dir=tmp_path / "var")


@pytest.fixture(scope="session")
def migrated_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A SQLite file with the current schema, made once: a copy is quicker than all migrations."""
    file = tmp_path_factory.mktemp("migrated") / "empty.sqlite3"
    asyncio.run(_migrate(f"sqlite:///{file}"))
    return file


@pytest.fixture
def app(
    settings: Settings, study: Study, migrated_file: Path, monkeypatch: pytest.MonkeyPatch
) -> FastAPI:
    """The app on a fresh SQLite file. Nothing is compiled or loaded ahead: pages do not need it."""

    async def compile_nothing(folder: Path) -> None:
        del folder

    monkeypatch.setattr("server.app.prepare_kernels", compile_nothing)
    monkeypatch.setattr("server.app.PoolTrainer.warm_up", lambda self: None)
    settings.var_dir.mkdir(parents=True)
    shutil.copy(migrated_file, settings.var_dir / "varil.sqlite3")
    return create_app(settings, [study])


@pytest.fixture
def client(app: FastAPI) -> Iterator[TestClient]:
    """A browser at the app's door; redirects are not followed."""
    with TestClient(app, follow_redirects=False, raise_server_exceptions=False) as opened:
        yield opened


@pytest.fixture(scope="session")
def postgres_server() -> Iterator[str]:
    """Address of a real PostgreSQL server of our own, without a database name."""
    programs = find_programs()
    if programs is None:
        message = "PostgreSQL's server programs are missing: apt-get install postgresql"
        if os.environ.get("CI", "").lower() in ("1", "true"):
            pytest.fail(message)
        pytest.skip(message)
    with PostgresServer(programs) as server:
        yield server.url


@pytest.fixture(scope="session")
def postgres_template(postgres_server: str) -> str:
    """Name of a PostgreSQL database with the current schema, for others to be made like it."""
    asyncio.run(_create_database(postgres_server, "migrated"))
    asyncio.run(_migrate(f"{postgres_server}/migrated"))
    return "migrated"


@pytest.fixture
def postgres_url(postgres_server: str) -> str:
    """Address of an empty PostgreSQL database."""
    name = f"test_{uuid.uuid4().hex}"
    asyncio.run(_create_database(postgres_server, name))
    return f"{postgres_server}/{name}"


@pytest.fixture(params=["sqlite", pytest.param("postgresql", marks=pytest.mark.postgres)])
def empty_url(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """Address of an empty database, of each kind in turn."""
    if request.param == "sqlite":
        return f"sqlite:///{tmp_path / 'test.sqlite3'}"
    return str(request.getfixturevalue("postgres_url"))


@pytest.fixture
def postgres_migrated(postgres_server: str, postgres_template: str) -> str:
    """Address of a PostgreSQL database with the current schema and nothing in it."""
    name = f"test_{uuid.uuid4().hex}"
    asyncio.run(_create_database(postgres_server, name, postgres_template))
    return f"{postgres_server}/{name}"


@pytest.fixture(params=["sqlite", pytest.param("postgresql", marks=pytest.mark.postgres)])
def migrated_url(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """Address of a database with the current schema and nothing in it, of each kind in turn."""
    if request.param == "sqlite":
        file = tmp_path / "test.sqlite3"
        shutil.copy(request.getfixturevalue("migrated_file"), file)
        return f"sqlite:///{file}"
    return str(request.getfixturevalue("postgres_migrated"))


@pytest.fixture
async def database(migrated_url: str) -> AsyncIterator[Database]:
    """A database with the current schema, of each kind in turn."""
    opened = Database(migrated_url)
    yield opened
    await opened.close()


async def _migrate(url: str) -> None:
    database = Database(url)
    await migrate(database)
    await database.close()


async def _create_database(server: str, name: str, template: str = "template1") -> None:
    engine = create_async_engine(
        server.replace("postgresql:", "postgresql+asyncpg:") + "/postgres",
        isolation_level="AUTOCOMMIT",
    )
    async with engine.connect() as connection:
        await connection.execute(text(f"CREATE DATABASE {name} TEMPLATE {template}"))
    await engine.dispose()
