"""Guards the way from and to a recruitment panel: one person once, and only to named hosts."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from fastapi import FastAPI
from sqlalchemy import func, select
from starlette.testclient import TestClient

from server.app import create_app
from server.desks.participants import ParticipantDesk
from server.settings import Settings
from server.store.engine import Database
from server.store.schema import migrate
from server.store.tables import PanelId, Participant
from study.config import Study
from study.errors import UnknownToken

ID = {"PROLIFIC_PID": "5f3aB1"}


@pytest.fixture
def panel() -> dict[str, Any]:
    """What the study says of its panel, beside the host."""
    return {}


@pytest.fixture
def study(study: Study, panel: dict[str, Any]) -> Study:
    """A study whose panel wants people back."""
    name = panel.get("parameters", ["PROLIFIC_PID"])[0]
    back = f"https://app.prolific.example/done?cc={{code}}&who={{{name}}}"
    endings = {
        outcome: ending.model_dump() | ({} if outcome == "timed-out" else {"redirect": back})
        for outcome, ending in study.endings.items()
    }
    hosts = {"hosts": ["app.prolific.example"]}
    return study.revised(endings=endings, panel=study.panel.model_dump() | hosts | panel)


def people(client: TestClient, app: FastAPI) -> int:
    async def run() -> int:
        async with app.state.services.database.reading() as session:
            return await session.scalar(select(func.count()).select_from(Participant)) or 0

    assert client.portal is not None
    return client.portal.call(run)


def join(client: TestClient, ids: dict[str, str]) -> str:
    answer = client.post("/s/demo", data=ids)
    assert answer.status_code == 303, answer.text
    return str(answer.headers["location"])


def test_the_same_person_comes_back_to_the_same_place(client: TestClient, app: FastAPI) -> None:
    """From another tab or device, with other session parameters, and with blanks around the id."""
    first = join(client, ID)
    client.post(f"{first}/consent", data={"adult": "yes", "informed": "yes", "agreed": "yes"})
    assert join(client, ID | {"SESSION_ID": "other"}) == first
    assert join(client, {"PROLIFIC_PID": " 5f3aB1 "}) == first
    assert people(client, app) == 1


def test_capitals_tell_two_people_apart_unless_the_study_says_otherwise(
    client: TestClient, app: FastAPI
) -> None:
    assert join(client, ID) != join(client, {"PROLIFIC_PID": "5f3ab1"})
    assert people(client, app) == 2


@pytest.mark.parametrize("panel", [{"ignore_case": True}])
def test_a_study_may_take_capitals_as_equal(client: TestClient, app: FastAPI) -> None:
    assert join(client, ID) == join(client, {"PROLIFIC_PID": "5F3AB1"})
    assert people(client, app) == 1


def test_without_an_id_everybody_is_somebody_new(client: TestClient, app: FastAPI) -> None:
    """Also with the panel's own name of the parameter left unfilled."""
    for ids in ({}, {"PROLIFIC_PID": ""}, {"PROLIFIC_PID": "{{%PROLIFIC_PID%}}"}):
        join(client, ids)
    assert people(client, app) == 3


@pytest.mark.parametrize("panel", [{"required": True}])
@pytest.mark.parametrize("ids", [{}, {"PROLIFIC_PID": " "}, {"PROLIFIC_PID": "{{%PROLIFIC_PID%}}"}])
def test_a_study_may_require_the_id_and_then_explains(
    client: TestClient, app: FastAPI, ids: dict[str, str]
) -> None:
    for answer in (client.get("/s/demo", params=ids), client.post("/s/demo", data=ids)):
        assert answer.status_code == 400
        assert "Please come through your recruitment panel" in answer.text
        assert "PROLIFIC_PID is missing" in answer.text
    assert client.get("/s/demo", params=ID).status_code == 200
    assert people(client, app) == 0


def test_an_id_of_no_use_is_refused(client: TestClient, app: FastAPI) -> None:
    answer = client.post("/s/demo", data={"PROLIFIC_PID": "x" * 201})
    assert (answer.status_code, people(client, app)) == (400, 0)
    assert "longer than 200 characters" in answer.text


@pytest.mark.parametrize("panel", [{"parameters": ["who", "SONA_ID"], "identifier": "SONA_ID"}])
def test_any_names_will_do(client: TestClient, app: FastAPI, study: Study) -> None:
    first = join(client, {"SONA_ID": "7", "who": "a"})
    assert join(client, {"SONA_ID": "7", "who": "b"}) == first
    assert join(client, {"SONA_ID": "8", "who": "a"}) != first
    assert people(client, app) == 2


def test_who_took_part_already_is_told_politely(walk: Callable[[str], Any]) -> None:
    walker = walk("debrief")
    again = walker.client.post("/s/demo", data=ID)
    assert again.status_code == 409
    assert "You have taken part already" in again.text
    assert walker.page().status_code == 200


@pytest.fixture
def walk(client: TestClient, walker: Any) -> Callable[[str], Any]:
    """A person of the panel, walked to a step."""

    def walked(step: str) -> Any:
        walker.address = join(client, ID)
        walker.walk_to(step)
        return walker

    return walked


def test_the_panel_is_gone_back_to_only_after_the_end(
    walk: Callable[[str], Any], study: Study
) -> None:
    walker = walk("comments")
    assert "/return" not in walker.page().text
    assert walker.client.get(f"{walker.address}/return").headers["location"] == walker.address
    walker.walk_to("debrief")
    assert f'href="{walker.address}/return"' in walker.page().text
    code = study.completion_codes["completed"]
    assert walker.client.get(f"{walker.address}/return").headers["location"] == (
        f"https://app.prolific.example/done?cc={code}&who=5f3aB1"
    )
    walker.send("withdraw")
    code = study.completion_codes["withdrawn"]
    assert f"cc={code}&" in walker.client.get(f"{walker.address}/return").headers["location"]


def test_only_a_host_that_the_study_names_is_gone_to(
    walk: Callable[[str], Any], study: Study, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Even if a stored version should name another: the study file would refuse it before."""
    walker = walk("debrief")
    panel = study.panel.model_copy(update={"hosts": ("elsewhere.example",)})
    changed = study.model_copy(update={"panel": panel})
    monkeypatch.setattr(ParticipantDesk, "_study_of", lambda self, who: _given(changed))
    assert "/return" not in walker.page().text
    assert walker.client.get(f"{walker.address}/return").headers["location"] == walker.address


async def _given(study: Study) -> Study:
    return study


def test_each_outcome_has_a_code_of_its_own(study: Study) -> None:
    codes = [ending.code for ending in study.endings.values()]
    assert len(set(codes)) == len(codes) == 5


async def test_a_new_secret_key_makes_nobody_a_second_person(study: Study, tmp_path: Path) -> None:
    database = Database(f"sqlite:///{tmp_path / 'a.sqlite3'}")
    await migrate(database)
    desks = [ParticipantDesk(database, {"demo": study}, key * 32) for key in (b"a", b"b")]
    first, second = [await desk.join("demo", "", ID) for desk in desks]
    assert first != second
    with pytest.raises(UnknownToken):
        await desks[0].look_up(first)
    assert (await desks[0].look_up(second)).participant.progress.step == "consent"
    await database.close()


async def test_two_links_at_the_same_moment_are_one_person(
    database: Database, study: Study
) -> None:
    """On both kinds of database: the second finds what the first has stored."""
    desk = ParticipantDesk(database, {"demo": study}, b"k" * 32)
    await desk.register_studies()
    tokens = await asyncio.gather(*(desk.join("demo", "", ID) for _ in range(8)))
    assert len(set(tokens)) == 1
    async with database.reading() as session:
        for table in (Participant, PanelId):
            assert await session.scalar(select(func.count()).select_from(table)) == 1


def test_the_app_serves_such_a_study(settings: Settings, study: Study) -> None:
    assert create_app(settings, [study]).state.services.participants.find_study("demo") == study
