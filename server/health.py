"""The health check behind `varil doctor`: what the server needs of its machine, one by one."""

from __future__ import annotations

import asyncio
import importlib.metadata
import os
import shutil
import socket
import sys
import tempfile
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from server.kernel_cache import kernel_digest, kernel_folder
from server.live.compiling import COMPLETE
from server.locations import web_root
from server.pages.rendering import MissingAssets, Renderer
from server.serving import PortInUse, bind
from server.settings import Settings
from server.store.engine import Database, StorageAway, sqlite_file
from server.store.schema import read_versions
from study.errors import StudyError

OLDEST_PYTHON = (3, 11)
LEAST_FREE_MB = 500


@dataclass(frozen=True)
class Check:
    """One finding; `next_step` says what to do where it is not well."""

    name: str
    is_well: bool
    found: str
    next_step: str = ""


def examine(settings: Settings) -> list[Check]:
    """Every check, whatever the others find. Nothing is changed but for a file written and gone."""
    checks: tuple[tuple[str, Callable[[Settings], Check]], ...] = (
        ("Python", _check_python),
        ("browser client", _check_client),
        ("compiled kernels", _check_kernels),
        ("data folder", _check_folder),
        ("free disk", _check_disk),
        ("database", _check_database),
        ("port", _check_port),
    )
    found = []
    for name, check in checks:
        try:
            found.append(check(settings))
        except StudyError as error:
            found.append(Check(name, False, error.what, error.next_step))
        except OSError as error:
            found.append(Check(name, False, str(error), "Mend what the message names."))
    return found


def _check_python(settings: Settings) -> Check:
    del settings
    version = ".".join(map(str, sys.version_info[:3]))
    libraries = ", ".join(
        f"{name} {importlib.metadata.version(name)}" for name in ("numpy", "numba", "sqlalchemy")
    )
    return Check(
        "Python",
        sys.version_info >= OLDEST_PYTHON,
        f"{version}, {libraries}",
        "Install Python 3.11 or newer, then `make install`.",
    )


def _check_client(settings: Settings) -> Check:
    del settings
    try:
        Renderer(web_root()).assets.check()
    except MissingAssets as error:
        return Check("browser client", False, error.what, error.next_step)
    return Check("browser client", True, str(web_root() / "static" / "dist"))


def _check_kernels(settings: Settings) -> Check:
    del settings
    folder = kernel_folder()
    if not _is_writable(folder):
        return Check(
            "compiled kernels",
            False,
            f"{folder} cannot be written: every start compiles anew, for about a minute",
            "Give a folder that this account may write to with VARIL_CACHE_DIR.",
        )
    is_there = (folder / kernel_digest() / COMPLETE).exists()
    state = "compiled" if is_there else "not compiled yet; the first start takes a minute longer"
    return Check("compiled kernels", True, f"{folder}: {state}")


def _check_folder(settings: Settings) -> Check:
    return Check(
        "data folder",
        _is_writable(settings.var_dir),
        str(settings.var_dir.absolute()),
        "Give a folder that this account may write to with VARIL_VAR_DIR.",
    )


def _check_disk(settings: Settings) -> Check:
    file = sqlite_file(settings.database)
    place = _nearest(file.parent if file else settings.var_dir)
    free_mb = shutil.disk_usage(place).free // 1_000_000
    return Check(
        "free disk",
        free_mb >= LEAST_FREE_MB,
        f"{free_mb} MB free at {place.absolute()}",
        f"Make room: {LEAST_FREE_MB} MB at least. A trial takes about 0.3 MB.",
    )


def _check_database(settings: Settings) -> Check:
    file = sqlite_file(settings.database)
    if file is not None and not file.exists():
        well = _is_writable(file.parent)
        advice = "Give another place with VARIL_DATABASE_URL."
        return Check("database", well, f"{file}: none yet, the first start makes it", advice)
    try:
        has, wanted = asyncio.run(_read_versions(settings.database))
    except StorageAway as error:
        return Check(
            "database",
            False,
            f"it does not answer ({error.__cause__ or 'no reason given'})",
            "Check that it runs and that VARIL_DATABASE_URL names it.",
        )
    if file is not None and not os.access(file, os.W_OK):
        return Check("database", False, f"{file} cannot be written", "Mend its permissions.")
    found = f"{file or 'PostgreSQL'}, schema {has or 'none'}" + (
        "" if has == wanted else f", this software needs {wanted}"
    )
    return Check("database", has == wanted, found, "Make a backup, then run `varil migrate`.")


async def _read_versions(url: str) -> tuple[str | None, str]:
    database = Database(url)
    try:
        return await read_versions(database)
    finally:
        await database.close()


def _check_port(settings: Settings) -> Check:
    place = f"{settings.host}:{settings.port}"
    try:
        with closing(bind(settings.host, settings.port)):
            return Check("port", True, f"{place} is free")
    except PortInUse as error:
        if _speaks_varil(settings):
            return Check("port", True, f"{place}: a VARIL server answers there")
        return Check("port", False, error.what, error.next_step)


def _speaks_varil(settings: Settings) -> bool:
    """Whether what holds the port answers as this server does."""
    host = "127.0.0.1" if settings.host in ("0.0.0.0", "::") else settings.host  # noqa: S104
    request = f"GET /healthz HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n"
    try:
        with socket.create_connection((host, settings.port), timeout=3) as line:
            line.sendall(request.encode())
            answer = line.makefile("rb").read(4096)
    except OSError:
        return False
    return b'{"status":"ok"}' in answer


def _is_writable(folder: Path) -> bool:
    """Whether files can be made there, or the folder itself can be."""
    folder = place = folder.absolute()
    while not place.exists():
        place = place.parent
    if place != folder or not place.is_dir():
        return place.is_dir() and os.access(place, os.W_OK | os.X_OK)
    try:
        with tempfile.TemporaryFile(dir=place):
            return True
    except OSError:
        return False


def _nearest(folder: Path) -> Path:
    """The folder, or the nearest one above it that exists."""
    folder = folder.absolute()
    return next(place for place in (folder, *folder.parents) if place.is_dir())
