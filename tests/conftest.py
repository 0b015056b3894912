"""Fixtures for the whole suite: a study, databases of both kinds, the app and its client."""

from __future__ import annotations

import asyncio
import os
import pwd
import shutil
import socket
import subprocess
import tempfile
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


@pytest.fixture
def app(settings: Settings, study: Study, monkeypatch: pytest.MonkeyPatch) -> FastAPI:
    """The app on a fresh SQLite file. The world is not compiled ahead: pages do not need it."""

    async def compile_nothing(folder: Path) -> None:
        del folder

    monkeypatch.setattr("server.app.prepare_kernels", compile_nothing)
    asyncio.run(_migrate(settings.database))
    return create_app(settings, [study])


@pytest.fixture
def client(app: FastAPI) -> Iterator[TestClient]:
    """A browser at the app's door; redirects are not followed."""
    with TestClient(app, follow_redirects=False, raise_server_exceptions=False) as opened:
        yield opened


@pytest.fixture(scope="session")
def postgres_server() -> Iterator[str]:
    """Address of a real PostgreSQL server of our own, without a database name."""
    programs = _postgres_programs()
    folder = Path(tempfile.mkdtemp(prefix="varil-postgres-"))
    account = "postgres" if os.geteuid() == 0 else None
    if account:
        os.chown(folder, pwd.getpwnam(account).pw_uid, -1)
    port = _free_port()
    data = folder / "data"
    try:
        _run([programs / "initdb", "-D", data, "-U", "varil", "-A", "trust", "-N"], account)
        options = f"-p {port} -k {folder} -c listen_addresses=127.0.0.1 -c fsync=off"
        control = [programs / "pg_ctl", "-D", data, "-w", "-l", folder / "log"]
        _run([*control, "-o", options, "start"], account)
        try:
            yield f"postgresql://varil@127.0.0.1:{port}"
        finally:
            _run([*control, "-m", "immediate", "stop"], account)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


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
async def database(empty_url: str) -> AsyncIterator[Database]:
    """A database with the current schema, of each kind in turn."""
    opened = Database(empty_url)
    await migrate(opened)
    yield opened
    await opened.close()


async def _migrate(url: str) -> None:
    database = Database(url)
    await migrate(database)
    await database.close()


async def _create_database(server: str, name: str) -> None:
    engine = create_async_engine(
        server.replace("postgresql:", "postgresql+asyncpg:") + "/postgres",
        isolation_level="AUTOCOMMIT",
    )
    async with engine.connect() as connection:
        await connection.execute(text(f"CREATE DATABASE {name}"))
    await engine.dispose()


def _postgres_programs() -> Path:
    found = sorted(Path("/usr/lib/postgresql").glob("*/bin/initdb"))
    on_path = shutil.which("initdb")
    if found or on_path:
        return (found[-1] if found else Path(str(on_path))).parent
    message = "PostgreSQL's server programs are missing: apt-get install postgresql"
    if os.environ.get("CI", "").lower() in ("1", "true"):
        pytest.fail(message)
    pytest.skip(message)


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def _run(words: list[str | Path], account: str | None) -> None:
    """Run one of PostgreSQL's programs; it refuses to run as root, hence the account.

    Output goes to a file: the server inherits it, and a pipe would be held open for ever.
    """
    with tempfile.TemporaryFile("w+") as output:
        done = subprocess.run(words, user=account, cwd="/", stdout=output, stderr=output)
        output.seek(0)
        assert done.returncode == 0, f"{words[0]} failed:\n{output.read()}"
