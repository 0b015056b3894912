"""The schema's version: bring a database to the current one, or refuse another."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sqlalchemy import Connection, inspect, text

from server.locations import migrations_root
from server.store.engine import Database
from study.errors import StudyError

if TYPE_CHECKING:  # loaded only when there is something to migrate: it costs every start otherwise
    from alembic.config import Config
    from alembic.script import ScriptDirectory

CURRENT = "0004"
"""The newest revision below migrations/versions; a test holds the two equal."""


class SchemaMismatch(StudyError):
    """The database was made by another version of this software."""

    def __init__(self, found: str | None, wanted: str, *, newer: bool) -> None:
        self.found = found
        self.wanted = wanted
        what = (
            f"the database has the schema version {found}, this software needs {wanted}"
            if found
            else f"the database has no schema yet, this software needs version {wanted}"
        )
        advice = (
            "That version is unknown here: install the newer software that made this database."
            if newer
            else "Make a backup, then run `varil migrate`."
        )
        super().__init__(what, next_step=advice)


async def migrate(database: Database) -> tuple[str | None, str]:
    """Bring the database to the current schema; returns the versions before and after.

    Raises `SchemaMismatch` if the database is newer than this software.
    """
    found, wanted = await read_versions(database)
    if found == wanted:
        return found, wanted
    _refuse_newer(found, wanted)
    async with database.rebuilding() as connection:
        await connection.run_sync(_upgrade)
    return found, wanted


async def check_schema(database: Database) -> None:
    """Raise `SchemaMismatch` unless the database has the current schema."""
    found, wanted = await read_versions(database)
    if found != wanted:
        _refuse_newer(found, wanted)
        raise SchemaMismatch(found, wanted, newer=False)


async def read_versions(database: Database) -> tuple[str | None, str]:
    """The database's version (None: empty) and the one this software needs."""
    async with database.reading() as session:
        connection = await session.connection()
        return await connection.run_sync(_stored_version), CURRENT


def _stored_version(connection: Connection) -> str | None:
    """What Alembic wrote into its table; None if there is no such table or row."""
    if not inspect(connection).has_table("alembic_version"):
        return None
    return connection.execute(text("SELECT version_num FROM alembic_version")).scalar()


def _refuse_newer(found: str | None, wanted: str) -> None:
    known = {script.revision for script in _scripts().walk_revisions()}
    if found is not None and found not in known:
        raise SchemaMismatch(found, wanted, newer=True)


def _upgrade(connection: Connection) -> None:
    from alembic import command

    config = _config()
    config.attributes["connection"] = connection
    command.upgrade(config, "head")


def _scripts() -> ScriptDirectory:
    from alembic.script import ScriptDirectory

    return ScriptDirectory.from_config(_config())


def _config() -> Config:
    from alembic.config import Config

    config = Config()
    config.set_main_option("script_location", str(migrations_root()).replace("%", "%%"))
    return config
