"""What verbs need before they begin: the settings, and a database that exists."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from study.errors import InvalidValue, NotFound

if TYPE_CHECKING:
    from server.settings import Settings


def read_settings(**given: Any) -> Settings:
    """Settings from the environment, with what the command line gave on top."""
    from pydantic_settings import SettingsError

    from server.settings import Settings

    try:
        return Settings(**{name: value for name, value in given.items() if value is not None})
    except SettingsError as error:
        raise InvalidValue(
            f"the environment cannot be read ({error})",
            next_step='Lists are written as JSON, as in VARIL_ALLOWED_ORIGINS=["https://a.example"].',
        ) from error


def require_database(settings: Settings) -> None:
    """Raise `NotFound` where a SQLite file does not exist yet: reading verbs make none."""
    from server.store.engine import sqlite_file

    file = sqlite_file(settings.database)
    if file is not None and not file.is_file():
        raise NotFound(
            f"there is no database at {file}",
            next_step="Run this where `varil serve` runs, or give --database-url.",
        )
