"""Guards the schema: made by migrations alone, on both kinds of database, and never guessed."""

from __future__ import annotations

from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.config import Config
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import Connection, text

from server.locations import migrations_root
from server.store.engine import (
    Database,
    DatabaseInUse,
    StorageAway,
    UnusableDatabase,
    async_url,
    serve_alone,
)
from server.store.schema import CURRENT, SchemaMismatch, check_schema, migrate, read_versions
from server.store.tables import Base


async def test_migrations_make_exactly_the_tables_of_the_code(database: Database) -> None:
    def differences(connection: Connection) -> list[object]:
        context = MigrationContext.configure(connection, opts={"compare_type": True})
        return list(compare_metadata(context, Base.metadata))

    async with database.engine.connect() as connection:
        assert await connection.run_sync(differences) == []


def test_the_version_in_the_code_is_the_newest_revision() -> None:
    """The constant spares every start the loading of the migration tool."""
    config = Config()
    config.set_main_option("script_location", str(migrations_root()))
    assert ScriptDirectory.from_config(config).get_current_head() == CURRENT


async def test_an_empty_database_is_refused_then_migrated_then_accepted(empty_url: str) -> None:
    database = Database(empty_url)
    with pytest.raises(SchemaMismatch, match="varil migrate"):
        await check_schema(database)
    before, after = await migrate(database)
    assert before is None
    await check_schema(database)
    assert await migrate(database) == (after, after)
    await database.close()


async def test_a_database_of_a_newer_version_is_refused_and_left_alone(database: Database) -> None:
    async with database.writing() as session:
        await session.execute(text("UPDATE alembic_version SET version_num = '9999'"))
    for act in (check_schema, migrate):
        with pytest.raises(SchemaMismatch, match="install the newer software"):
            await act(database)
    assert (await read_versions(database))[0] == "9999"


async def test_a_failed_transaction_leaves_nothing(database: Database) -> None:
    async def fail_half_way() -> None:
        async with database.writing() as session:
            await session.execute(
                text("INSERT INTO audit VALUES (1, '2026-01-01 00:00:00', 'ann', 'signed in', '')")
            )
            raise RuntimeError("half way")

    with pytest.raises(RuntimeError, match="half way"):
        await fail_half_way()
    async with database.reading() as session:
        assert (await session.execute(text("SELECT count(*) FROM audit"))).scalar() == 0


async def test_sqlite_is_set_up_for_a_server(tmp_path: Path) -> None:
    database = Database(f"sqlite:///{tmp_path / 'deep' / 'er' / 'a.sqlite3'}")
    async with database.reading() as session:
        found = {
            name: (await session.execute(text(f"PRAGMA {name}"))).scalar()
            for name in ("journal_mode", "foreign_keys", "busy_timeout")
        }
    assert found == {"journal_mode": "wal", "foreign_keys": 1, "busy_timeout": 10_000}
    await database.close()


async def test_two_servers_on_one_database_are_refused(empty_url: str) -> None:
    """On both kinds: two servers would run the same trial twice."""
    first, second = Database(empty_url), Database(empty_url)
    async with serve_alone(first):
        with pytest.raises(DatabaseInUse, match="another server"):
            async with serve_alone(second):
                pass
    async with serve_alone(second):
        pass
    await first.close()
    await second.close()


async def test_a_database_that_does_not_answer_is_told_as_such() -> None:
    database = Database("postgresql://nobody@127.0.0.1:1/none")
    with pytest.raises(StorageAway, match="try again"):
        await database.ping()
    await database.close()


@pytest.mark.parametrize(
    ("url", "driver"),
    [
        ("sqlite:///a.db", "sqlite+aiosqlite:///a.db"),
        ("sqlite:////var/a.db", "sqlite+aiosqlite:////var/a.db"),
        ("postgresql://u:p%40ss@h/n", "postgresql+asyncpg://u:p%40ss@h/n"),
        ("postgres://u@h/n", "postgresql+asyncpg://u@h/n"),
    ],
)
def test_addresses_are_mapped_to_the_drivers(url: str, driver: str) -> None:
    assert async_url(url) == driver


@pytest.mark.parametrize("url", ["mysql://h/n", "sqlite://", "nonsense", "sqlite:///:memory:"])
def test_other_addresses_are_refused_without_repeating_them(url: str) -> None:
    with pytest.raises(UnusableDatabase, match="sqlite:///path"):
        async_url(url)
