"""Guards a participant's story whatever became of them: what it says, and excluding them or not."""

from __future__ import annotations

import re
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Any

import pytest
from starlette.testclient import TestClient

from server.desks.lives import LifeDesk
from server.store.dashboard import count_crowds
from server.store.moves import alter
from server.store.participants import find_by_code
from study.protocol.lifecycle import STATUSES, Act

Lead = tuple[str, str]
LIVES: dict[str, tuple[str, tuple[Act, ...]]] = {
    "joined": ("", ()),
    "active": ("explanation-1", ()),
    "paused": ("explanation-1", ("pause",)),
    "completed": ("debrief", ()),
    "screened-out": ("demographics", ("screen-out",)),
    "timed-out": ("explanation-1", ("time-out",)),
    "withdrawn": ("explanation-1", ("withdraw",)),
    "excluded": ("explanation-1", ("exclude",)),
}
"""How somebody comes to each status: the step to walk to, and what happens then."""


def bring_to(walker: Any, status: str) -> str:
    """Let a fresh participant come to a status; returns the code."""
    step, acts = LIVES[status]
    if step:
        walker.walk_to(step)
    services, portal = walker.app.state.services, walker.client.portal
    code = str(portal.call(services.participants.look_up, walker.token).participant.code)

    async def happen() -> None:
        for act in acts:
            async with services.database.writing() as session:
                person = await find_by_code(session, code)
                await alter(session, person, act, ("as tests go", "server"), datetime.now(UTC))

    portal.call(happen)
    return code


def crowds(walker: Any) -> set[Any]:
    """Everybody in groups, as the flow and the cells are counted."""
    database = walker.app.state.services.database

    async def count() -> set[Any]:
        async with database.reading() as session:
            return set(await count_crowds(session, "demo"))

    found: set[Any] = walker.client.portal.call(count)
    return found


def lead(page: Any) -> Lead:
    """The status on top of a story, and what it was before."""
    assert page.status_code == 200
    status = re.search(r'class="status ([\w-]+)">\1</span>', page.text)
    assert status is not None
    before = re.search(r"\(was ([\w-]+)\)", page.text)
    return status[1], before[1] if before else ""


def test_every_status_has_its_story() -> None:
    assert set(LIVES) == set(STATUSES)


@pytest.mark.parametrize("status", [s for s in LIVES if s not in ("withdrawn", "excluded")])
def test_whoever_is_excluded_can_come_back_as_they_were(
    join: Callable[[], Any], sign_in_as: Callable[[str], TestClient], status: str
) -> None:
    """From every status: the story says what it was, and coming back leaves no trace in counts."""
    walker = join()
    code = bring_to(walker, status)
    before, admin = crowds(walker), sign_in_as("admin")
    address = f"/admin/participants/{code}"
    assert lead(admin.get(address)) == (status, "")
    assert admin.post(f"{address}/reinstate", data={"reason": "x"}).status_code == 409
    assert admin.post(f"{address}/exclude", data={"reason": "slept"}).status_code == 303
    page = admin.get(address)
    assert lead(page) == ("excluded", status)
    assert f"Becomes <strong>{status}</strong> again" in page.text
    assert crowds(walker) != before
    assert admin.post(f"{address}/exclude", data={"reason": "again"}).status_code == 409
    assert admin.post(f"{address}/reinstate", data={"reason": "was awake"}).status_code == 303
    assert lead(admin.get(address)) == (status, "")
    assert crowds(walker) == before
    places = admin.get(address).text.split("Places in the design")[1]
    if status in ("active", "paused", "completed"):
        assert "released" in places
        assert "(reinstated)" in places
    else:
        assert "(reinstated)" not in places


def test_one_who_withdrew_or_was_erased_is_left_alone(
    join: Callable[[], Any], sign_in_as: Callable[[str], TestClient]
) -> None:
    """Nothing is offered, and nothing that is sent changes anything."""
    walker, other = join(), join()
    gone, erased = bring_to(walker, "withdrawn"), bring_to(other, "excluded")
    desk = LifeDesk(walker.app.state.services.database)
    assert walker.client.portal is not None
    walker.client.portal.call(desk.erase, erased, "command line")
    admin, before = sign_in_as("admin"), crowds(walker)
    for code, words in ((gone, "withdrew; that is final"), (erased, "data were erased")):
        address = f"/admin/participants/{code}"
        page = admin.get(address)
        assert lead(page) == ("withdrawn", "")
        assert words in page.text
        assert f"{address}/exclude" not in page.text
        for act in ("exclude", "reinstate"):
            answer = admin.post(f"{address}/{act}", data={"reason": "x"})
            assert answer.status_code == 409, (code, act)
    note = admin.post(f"/admin/participants/{erased}/note", data={"note": "x"})
    assert note.status_code == 409, "it would outlive the erasure"
    assert crowds(walker) == before
