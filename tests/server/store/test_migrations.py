"""Guards upgrades: a database with data of an older version keeps all of it, on both kinds."""

from __future__ import annotations

import json
from typing import Any

import pytest
from alembic import command
from alembic.config import Config
from sqlalchemy import Connection, text
from sqlalchemy.exc import IntegrityError

from server.locations import migrations_root
from server.store.engine import Database
from server.store.schema import CURRENT, check_schema, migrate
from study.learning.policy import initial_policy

AT = "2026-01-02 03:04:05"
POLICY = initial_policy()
FIRST = {
    "study_versions": [(1, "demo", "h" * 64, "{}", AT)],
    "participants": [
        (
            1, "P-1", "t" * 64, 1, "demo", "pilot", False, "trial-1", 1, None, 0, 2, AT, AT,
            None, None,
        )
    ],
    "policies": [(POLICY.sha256, POLICY.to_json(), AT)],
    "trials": [
        (
            "a" * 32, 1, "trial-1", 1, "trial", 1, "varil", "Display A", "study", 2**62,
            "h" * 64, json.dumps({"seed": 2**62}), POLICY.sha256, "open", "running", 61, None, AT,
            *([None] * 11),
        )
    ],
    "trial_events": [("a" * 32, 0, 5, "paused", AT, "{}")],
    "trial_legs": [("a" * 32, 0, 0, "waiting", 0.5, 1.5, 2.0, None, 3, 1, True)],
}  # fmt: skip


def upgrade_to(revision: str) -> Any:
    def run(connection: Connection) -> None:
        config = Config()
        config.set_main_option("script_location", str(migrations_root()))
        config.attributes["connection"] = connection
        command.upgrade(config, revision)

    return run


def literal(value: object) -> str:
    if value is None or isinstance(value, bool):
        return {None: "NULL", True: "true", False: "false"}[value]
    return (
        str(value) if isinstance(value, int | float) else "'" + str(value).replace("'", "''") + "'"
    )


async def fill(database: Database, tables: dict[str, list[tuple[Any, ...]]]) -> None:
    async with database.engine.begin() as connection:
        for name, rows in tables.items():
            for row in rows:
                values = ", ".join(map(literal, row)).replace(":", "\\:")
                await connection.execute(text(f"INSERT INTO {name} VALUES ({values})"))


async def rows_of(database: Database, query: str) -> list[tuple[Any, ...]]:
    async with database.reading() as session:
        return [tuple(row) for row in await session.execute(text(query))]


async def test_data_of_the_first_version_survive(empty_url: str) -> None:
    """Trials, what refers to them, and policies, of which name and origin are read off."""
    database = Database(empty_url)
    async with database.rebuilding() as connection:
        await connection.run_sync(upgrade_to("0001"))
    await fill(database, FIRST)
    before = await rows_of(database, "SELECT id, step, seed, ticks, status FROM trials")
    assert await migrate(database) == ("0001", CURRENT)
    await check_schema(database)
    assert await rows_of(database, "SELECT id, step, seed, ticks, status FROM trials") == before
    owners = await rows_of(database, "SELECT participant_id, learning_run_id FROM trials")
    assert owners == [(1, None)]
    assert await rows_of(database, "SELECT name, origin, source FROM policies") == [
        ("initial", "initial", "shipped")
    ]
    for table in ("trial_events", "trial_legs"):
        assert await rows_of(database, f"SELECT trial_id FROM {table}") == [("a" * 32,)]
    await database.close()


@pytest.mark.parametrize(
    "change",
    [
        "INSERT INTO trial_events VALUES ('nobody', 0, 0, 'paused', '2026-01-01', '{}')",
        "UPDATE trials SET participant_id = NULL",
        "UPDATE trials SET participant_id = 99",
        "UPDATE trials SET learning_run_id = 'none'",
        "UPDATE trials SET kind = 'party'",
        "UPDATE trials SET status = 'lost'",
        "DELETE FROM trials",
    ],
)
async def test_rules_hold_after_an_upgrade_with_data(empty_url: str, change: str) -> None:
    """SQLite makes the table anew: neither its own rules nor references to it may get lost."""
    database = Database(empty_url)
    async with database.rebuilding() as connection:
        await connection.run_sync(upgrade_to("0001"))
    await fill(database, FIRST)
    await migrate(database)
    with pytest.raises(IntegrityError):
        async with database.writing() as session:
            await session.execute(text(change.replace(":", "\\:")))
    await database.close()


async def test_outcomes_become_statuses_with_a_history(empty_url: str) -> None:
    """What the second version knew of each participation is its first entries."""
    database = Database(empty_url)
    async with database.rebuilding() as connection:
        await connection.run_sync(upgrade_to("0002"))
    people = [("consent", None), ("practice", None), ("debrief", "completed")]
    rows = [
        (
            number,
            f"P-{number}",
            f"t{number}",
            1,
            "demo",
            "pilot",
            False,
            step,
            0,
            outcome,
            0,
            0,
            AT,
            AT,
            None,
            None,
        )
        for number, (step, outcome) in enumerate(people, 1)
    ]  # fmt: skip
    claims = [(n, "demo", "pilot", 3, 0, 0, kind, "", AT) for n, kind in ((1, "claimed"),)]
    tables = {"study_versions": FIRST["study_versions"], "participants": rows, "claims": claims}
    await fill(database, tables)
    await migrate(database)
    statuses = await rows_of(database, "SELECT status FROM participants ORDER BY id")
    assert statuses == [("joined",), ("active",), ("completed",)]
    history = "SELECT participant_id, from_status, to_status FROM participant_changes ORDER BY id"
    assert await rows_of(database, history) == [
        *((number, None, "joined") for number in (1, 2, 3)),
        (2, "joined", "active"),
        (3, "joined", "completed"),
    ]
    await fill(database, {"claims": [(n, *claims[0][1:]) for n in (2, 3)]})
    for wrong in ("status = 'lost'", "mode = 'party'", "study_version_id = 9"):
        with pytest.raises(IntegrityError):
            async with database.writing() as session:
                await session.execute(text(f"UPDATE participants SET {wrong}"))
    await database.close()


async def test_an_upgrade_that_breaks_half_way_changes_nothing(
    empty_url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All of it is one transaction; the references are checked before it is committed."""
    database = Database(empty_url)
    async with database.rebuilding() as connection:
        await connection.run_sync(upgrade_to("0001"))
    await fill(database, FIRST)

    def fail(connection: Connection) -> None:
        upgrade_to("0002")(connection)
        raise ZeroDivisionError

    monkeypatch.setattr("server.store.schema._upgrade", fail)
    with pytest.raises(ZeroDivisionError):
        await migrate(database)
    assert await rows_of(database, "SELECT version_num FROM alembic_version") == [("0001",)]
    assert await rows_of(database, "SELECT status FROM trials") == [("open",)]
    await database.close()


async def test_a_dangling_reference_stops_an_upgrade(tmp_path: Any) -> None:
    """Only SQLite can have one: its references are off while tables are made anew."""
    database = Database(f"sqlite:///{tmp_path / 'a.sqlite3'}")
    await migrate(database)
    with pytest.raises(RuntimeError, match="dangling reference"):
        async with database.rebuilding() as connection:
            await connection.exec_driver_sql(
                "INSERT INTO trial_events VALUES ('nobody', 0, 0, 'paused', '2026-01-01', '{}')"
            )
    assert await rows_of(database, "SELECT count(*) FROM trial_events") == [(0,)]
    await database.close()
