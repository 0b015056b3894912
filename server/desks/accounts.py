"""Staff accounts: adding them, the first administrator, and checking a password."""

from __future__ import annotations

import asyncio
import re
import secrets
from functools import cache

from pwdlib import PasswordHash

from server.desks.trials import utc_now
from server.settings import Settings
from server.store.audit import add_audit
from server.store.engine import Database
from server.store.users import Role, StaffRecord, count_admins, find_user, store_user
from study.errors import InvalidValue

SHORTEST_PASSWORD = 10
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}")


class AccountError(InvalidValue):
    """The name or password of a new account is not usable."""


async def add_user(database: Database, name: str, role: Role, password: str) -> bool:
    """Add an account or renew an existing one's role and password; True if it is new."""
    if not _NAME.fullmatch(name):
        raise AccountError(
            f"“{name[:70]}” cannot be an account's name",
            next_step="Use up to 64 letters, digits, dots, hyphens and underscores.",
        )
    if role not in ("admin", "expert"):
        raise AccountError(f"there is no role “{role}”", next_step="Use admin or expert.")
    if len(password) < SHORTEST_PASSWORD or len(password) > 1000:
        raise AccountError(
            f"the password has {len(password)} characters",
            next_step=f"Use at least {SHORTEST_PASSWORD}.",
        )
    hashed = await asyncio.to_thread(_hasher().hash, password)
    async with database.writing() as session:
        new = await store_user(session, name, role, hashed, utc_now())
        await add_audit(session, "command line", "user stored", f"{name} as {role}", utc_now())
    return new


async def ensure_admin(database: Database, settings: Settings) -> str | None:
    """Make the account `admin` if there is no administrator yet.

    Returns the password if it was drawn here, to be shown once; None if one was configured or an
    administrator exists.
    """
    async with database.reading() as session:
        if await count_admins(session):
            return None
    if settings.admin_password is not None:
        await add_user(database, "admin", "admin", settings.admin_password.get_secret_value())
        return None
    password = secrets.token_urlsafe(15)
    await add_user(database, "admin", "admin", password)
    return password


async def check_password(database: Database, name: str, password: str) -> StaffRecord | None:
    """The account if name and password fit. Takes the same time for unknown names."""
    async with database.reading() as session:
        user = await find_user(session, name)
    stored = user.password_hash if user else _decoy_hash()
    fits = await asyncio.to_thread(_hasher().verify, password[:1000], stored)
    return user if fits else None


@cache
def _hasher() -> PasswordHash:
    return PasswordHash.recommended()


@cache
def _decoy_hash() -> str:
    return _hasher().hash(secrets.token_urlsafe(15))
