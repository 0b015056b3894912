"""The database: its address, its transactions, its schema version, and who may serve from it."""

from __future__ import annotations

import asyncio
import fcntl
import os
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, event, make_url, text
from sqlalchemy.exc import DBAPIError, InterfaceError, OperationalError
from sqlalchemy.exc import TimeoutError as PoolTimeout
from sqlalchemy.ext.asyncio import AsyncConnection, AsyncEngine, AsyncSession, create_async_engine

from study.errors import StudyError

BUSY_TIMEOUT_MS = 10_000
_DRIVERS = {"sqlite": "sqlite+aiosqlite", "postgresql": "postgresql+asyncpg"}


class UnusableDatabase(StudyError):
    """The address of the database makes no sense here, or it cannot be opened."""


class DatabaseInUse(StudyError):
    """Another server already serves from this database."""

    def __init__(self, name: str) -> None:
        self.name = name
        super().__init__(
            f"another server is already running on the database {name}",
            next_step="Stop that server, or give this one another database with "
            "VARIL_DATABASE_URL.",
        )


class StorageAway(StudyError):
    """The database does not answer at the moment."""

    def __init__(self) -> None:
        super().__init__(
            "the server cannot reach its storage at the moment",
            next_step="Nothing that was confirmed is lost. Please try again in a minute.",
        )


def async_url(url: str) -> str:
    """The address with the driver that we use; raises `UnusableDatabase` for other kinds."""
    try:
        parsed = make_url(url)
    except Exception as error:
        raise UnusableDatabase(
            "the database address cannot be read",
            next_step="Write sqlite:///path/to/file or postgresql://user:password@host/name.",
        ) from error
    kind = parsed.drivername.split("+")[0]
    kind = "postgresql" if kind == "postgres" else kind
    if kind not in _DRIVERS or (kind == "sqlite" and parsed.database in (None, "", ":memory:")):
        raise UnusableDatabase(
            f"a database of the kind “{parsed.drivername}” without a file or name is not supported",
            next_step="Write sqlite:///path/to/file or postgresql://user:password@host/name.",
        )
    return parsed.set(drivername=_DRIVERS[kind]).render_as_string(hide_password=False)


def sqlite_file(url: str) -> Path | None:
    """The file behind a SQLite address, whether it exists or not; None for other databases."""
    parsed = make_url(async_url(url))
    return Path(parsed.database or "") if parsed.get_backend_name() == "sqlite" else None


class Database:
    """One engine with its transactions. `writing` commits at the end, `reading` never does."""

    def __init__(self, url: str) -> None:
        self.url = async_url(url)
        self.file = sqlite_file(url)
        self._write_lock = asyncio.Lock()
        self.engine = _make_engine(self.url, self.file)

    @asynccontextmanager
    async def writing(self) -> AsyncIterator[AsyncSession]:
        """A transaction that is committed unless the block raises.

        SQLite has one writer at a time, so within this process writers queue here rather than at
        the file's lock.
        """
        with _translate_trouble():
            if self.file is None:
                async with AsyncSession(self.engine) as session, session.begin():
                    yield session
                return
            async with self._write_lock, AsyncSession(self.engine) as session, session.begin():
                yield session

    @asynccontextmanager
    async def reading(self) -> AsyncIterator[AsyncSession]:
        """A consistent view of the data (a snapshot on both kinds of database)."""
        options: dict[str, Any] = {"varil_reading": True}
        if self.file is None:
            options = {"isolation_level": "REPEATABLE READ", "postgresql_readonly": True}
        reader = self.engine.execution_options(**options)
        with _translate_trouble():
            async with AsyncSession(reader) as session:
                yield session

    @asynccontextmanager
    async def rebuilding(self) -> AsyncIterator[AsyncConnection]:
        """A transaction in which tables are changed, committed unless the block raises.

        SQLite changes a table by making it anew, which no reference to it may hinder meanwhile:
        references are off in a connection of its own, and checked before it commits.
        """
        with _translate_trouble():
            if self.file is None:
                async with self.engine.begin() as connection:
                    yield connection
                return
            engine = _make_engine(self.url, self.file)
            event.listen(engine.sync_engine, "connect", _let_references_dangle)
            try:
                async with self._write_lock, engine.begin() as connection:
                    yield connection
                    dangling = await connection.exec_driver_sql("PRAGMA foreign_key_check")
                    if (row := dangling.first()) is not None:
                        raise RuntimeError(f"the change left a dangling reference: {tuple(row)}")
            finally:
                await engine.dispose()

    async def ping(self) -> None:
        """Raise `StorageAway` unless the database answers."""
        async with self.reading() as session:
            await session.execute(text("SELECT 1"))

    async def close(self) -> None:
        """Give all connections back."""
        await self.engine.dispose()


@asynccontextmanager
async def serve_alone(database: Database) -> AsyncIterator[None]:
    """Hold the database for as long as a server serves from it; raises `DatabaseInUse`.

    Two servers would run the same trial twice. A SQLite file is held by a lock file beside it,
    PostgreSQL by an advisory lock of one connection.
    """
    if database.file is None:
        async with _hold_advisory_lock(database):
            yield
        return
    lock = database.file.with_name(database.file.name + ".lock")
    handle = os.open(lock, os.O_RDWR | os.O_CREAT, 0o600)
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            raise DatabaseInUse(str(database.file)) from error
        yield
    finally:
        os.close(handle)


@asynccontextmanager
async def _hold_advisory_lock(database: Database) -> AsyncIterator[None]:
    with _translate_trouble():
        connection = await database.engine.connect()
    try:
        with _translate_trouble():
            got = await connection.scalar(text("SELECT pg_try_advisory_lock(hashtext('varil'))"))
            await connection.commit()
        if not got:
            raise DatabaseInUse(make_url(database.url).database or "")
        yield
    finally:
        await connection.invalidate()
        await connection.close()


@contextmanager
def _translate_trouble() -> Iterator[None]:
    """Turn “the database is away” into our own error; leave mistakes of ours as they are."""
    try:
        yield
    except (OperationalError, InterfaceError, PoolTimeout, ConnectionError) as error:
        raise StorageAway from error
    except DBAPIError as error:
        if "not a database" in str(error.orig):
            raise UnusableDatabase(
                "the file named as database holds something else",
                next_step="Name another file with VARIL_DATABASE_URL; this one was left as it is.",
            ) from error
        if error.connection_invalidated:
            raise StorageAway from error
        raise


def _make_engine(url: str, file: Path | None) -> AsyncEngine:
    if file is None:
        return create_async_engine(url, hide_parameters=True, pool_pre_ping=True, pool_size=10)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UnusableDatabase(
            f"the folder {file.parent} cannot be made ({error.strerror})",
            next_step="Give a folder that this account may write to with VARIL_DATABASE_URL.",
        ) from error
    engine = create_async_engine(
        url, hide_parameters=True, connect_args={"timeout": BUSY_TIMEOUT_MS / 1000}
    )
    event.listen(engine.sync_engine, "connect", _prepare_sqlite)
    event.listen(engine.sync_engine, "begin", _begin_sqlite)
    return engine


def _prepare_sqlite(connection: Any, record: object) -> None:
    """WAL, enforced foreign keys, patience; and transactions begun by us, not by the driver."""
    del record
    connection.isolation_level = None
    cursor = connection.cursor()
    for setting in (
        "journal_mode = WAL",
        "synchronous = FULL",
        "foreign_keys = ON",
        f"busy_timeout = {BUSY_TIMEOUT_MS}",
    ):
        cursor.execute(f"PRAGMA {setting}")
    cursor.close()


def _let_references_dangle(connection: Any, record: object) -> None:
    """Foreign keys can only be switched outside of a transaction, so for a whole connection."""
    del record
    cursor = connection.cursor()
    cursor.execute("PRAGMA foreign_keys = OFF")
    cursor.close()


def _begin_sqlite(connection: Connection) -> None:
    """Writers take the file's lock at once, so two of them never deadlock half way."""
    reading = connection.get_execution_options().get("varil_reading", False)
    connection.exec_driver_sql("BEGIN" if reading else "BEGIN IMMEDIATE")
