"""Guards what administrators' desk does to a running trial: more time for somebody absent."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from server.dashboard.watch import LONGEST_EXTENSION_S, LiveWatch, NotRunning
from server.desks.staff import AdminDesk
from server.store.engine import Database
from server.store.schema import migrate
from study.config import Study
from tests.server.export.site import Site


class BrokenStore(Exception):
    """The database gave up in the middle."""


@pytest.fixture
async def site(tmp_path: Path, study: Study, make_result: Any) -> AsyncIterator[Site]:
    database = Database(f"sqlite:///{tmp_path / 'a.sqlite3'}")
    await migrate(database)
    site = Site(database, study, make_result)
    await site.people.register_studies()
    yield site
    await database.close()


async def open_practice(site: Site) -> tuple[str, str, SimpleNamespace]:
    """Token and trial of somebody in the practice, and what stands for the room."""
    token = await site.walk(4, "4", "")
    trial_id = (await site.desk.open_trial(token)).setup.trial_id
    return token, trial_id, SimpleNamespace(abandon_after_s=3600.0)


def desk_of(site: Site, rooms: dict[str, Any]) -> AdminDesk:
    watch = LiveWatch(cast("Any", SimpleNamespace(rooms=rooms)))
    return AdminDesk(site.database, cast("Any", None), watch, 1.0)


async def test_more_time_holds_in_memory_and_after_a_restart(site: Site) -> None:
    """A trial that is opened again waits as long as staff said."""
    token, trial_id, room = await open_practice(site)
    await desk_of(site, {trial_id: room}).extend(trial_id, 30, "maria")
    assert room.abandon_after_s == 3600.0 + 1800.0
    assert (await site.desk.open_trial(token)).setup.abandon_after_s == 3600.0 + 1800.0


async def test_more_time_that_was_not_stored_holds_nowhere(
    site: Site, monkeypatch: pytest.MonkeyPatch
) -> None:
    token, trial_id, room = await open_practice(site)

    async def fail(*words: Any) -> None:
        raise BrokenStore

    monkeypatch.setattr("server.desks.staff.add_audit", fail)
    with pytest.raises(BrokenStore):
        await desk_of(site, {trial_id: room}).extend(trial_id, 30, "maria")
    assert room.abandon_after_s == 3600.0
    assert (await site.desk.open_trial(token)).setup.abandon_after_s == 3600.0


async def test_what_two_administrators_add_at_once_adds_up(site: Site) -> None:
    """Neither of them counts from a limit that the other one has just moved."""
    token, trial_id, room = await open_practice(site)
    desk = desk_of(site, {trial_id: room})
    await asyncio.gather(desk.extend(trial_id, 30, "maria"), desk.extend(trial_id, 10, "nora"))
    assert room.abandon_after_s == 3600.0 + 2400.0
    assert (await site.desk.open_trial(token)).setup.abandon_after_s == 3600.0 + 2400.0


async def test_only_a_running_trial_is_given_more_time(site: Site) -> None:
    _, trial_id, room = await open_practice(site)
    with pytest.raises(NotRunning):
        await desk_of(site, {}).extend(trial_id, 30, "maria")
    await desk_of(site, {trial_id: room}).extend(trial_id, 10**6, "maria")
    assert room.abandon_after_s == 3600.0 + LONGEST_EXTENSION_S
