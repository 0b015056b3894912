"""Guards the whole participation through the pages: one address, the right step, nothing twice."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import pytest
from fastapi import FastAPI
from sqlalchemy import func, select
from starlette.testclient import TestClient

from server.store.tables import PanelId, Participant, Response
from study.config import Study
from study.protocol.displays import SHOWN
from study.protocol.flow import Plan

PLAN = Plan(3, 3)
RATINGS = {f"Q{k}": str(k % 5 + 1) for k in range(1, 7)}


def count(client: TestClient, app: FastAPI, table: type) -> int:
    async def run() -> int:
        async with app.state.services.database.reading() as session:
            return await session.scalar(select(func.count()).select_from(table)) or 0

    assert client.portal is not None
    return client.portal.call(run)


def test_the_landing_page_stores_nothing_until_its_button(client: TestClient, app: FastAPI) -> None:
    for _ in range(3):
        assert client.get("/s/demo").status_code == 200
    assert count(client, app, Participant) == 0
    assert client.post("/s/demo").status_code == 303
    assert count(client, app, Participant) == 1


def test_a_landing_page_sent_twice_is_one_participant(client: TestClient, app: FastAPI) -> None:
    nonce = re.search(r'name="join" value="([^"]+)"', client.get("/s/demo").text)
    assert nonce is not None
    answers = [client.post("/s/demo", data={"join": nonce[1]}) for _ in range(2)]
    assert answers[0].headers["location"] == answers[1].headers["location"]
    assert count(client, app, Participant) == 1
    other = client.post("/s/demo", data={"join": "guessed"}).headers["location"]
    assert other != client.post("/s/demo", data={"join": "guessed"}).headers["location"]


def test_panel_ids_go_through_the_form_into_their_own_table(
    client: TestClient, app: FastAPI
) -> None:
    ids = {"PROLIFIC_PID": "p<1>", "STUDY_ID": "s2", "SESSION_ID": "e3"}
    page = client.get("/s/demo", params=ids | {"OTHER": "x"}).text
    fields = dict(re.findall(r'name="([A-Z_]+)" value="([^"]*)"', page))
    assert fields == ids | {"PROLIFIC_PID": "p&lt;1&gt;"}
    client.post("/s/demo", data=ids | {"OTHER": "x"})

    async def stored() -> dict[str, str]:
        async with app.state.services.database.reading() as session:
            return {row.name: row.value for row in await session.scalars(select(PanelId))}

    assert client.portal is not None
    assert client.portal.call(stored) == ids


def test_every_step_is_shown_at_the_one_address(walker: Any) -> None:
    """Also after a reload, and whichever step's address is opened by hand."""
    headings = {}
    for step in PLAN.steps:
        walker.walk_to(step)
        page = walker.page()
        assert page.status_code == 200
        assert page.text == walker.page().text
        assert walker.client.get(f"{walker.address}/{step}").headers["location"] == walker.address
        headings[step] = walker.heading()
    assert headings["consent"] == "Information and consent"
    assert headings["explanation-2"] == "Round 2: Display B"
    assert headings["trial-3"] == "Display C"
    assert headings["questionnaire-1"] == "About this round (Display A)"
    assert headings["debrief"] == "Thank you!"


def test_completion_shows_the_code_only_at_the_end(walker: Any, study: Study) -> None:
    code = study.completion_codes["completed"]
    for step in PLAN.steps[:-1]:
        walker.walk_to(step)
        assert code not in walker.page().text
    walker.walk_to("debrief")
    assert code in walker.page().text


def test_each_explanation_shows_exactly_the_elements_of_its_trial(
    walker: Any, study: Study
) -> None:
    walker.walk_to("explanation-1")
    portal, desk = walker.client.portal, walker.app.state.services.participants
    order = study.orders[portal.call(desk.look_up, walker.token).participant.slot.order_index]
    for position, condition in enumerate(order, 1):
        walker.walk_to(f"explanation-{position}")
        shown = re.findall(r"/static/img/elements/([a-z-]+)\.png", walker.page().text)
        assert tuple(shown) == SHOWN[condition].names


def test_the_play_page_carries_what_the_client_needs(walker: Any) -> None:
    walker.walk_to("practice")
    page = walker.page().text
    for needed in (
        f'data-live="{walker.address}/live"',
        f'data-next="{walker.address}"',
        'id="stage"',
        f'id="withdraw" href="{walker.address}/withdraw"',
        "<noscript>",
    ):
        assert needed in page


def test_the_same_form_again_leads_on_and_stores_nothing_more(
    walker: Any, client: TestClient, app: FastAPI
) -> None:
    walker.walk_to("questionnaire-1")
    assert walker.send("questionnaire-1", RATINGS).status_code == 303
    before = count(client, app, Response)
    again = walker.send("questionnaire-1", RATINGS)
    assert (again.status_code, again.headers["location"]) == (303, walker.address)
    assert count(client, app, Response) == before


def test_another_answer_to_a_step_that_is_behind_is_refused(
    walker: Any, client: TestClient, app: FastAPI
) -> None:
    walker.walk_to("explanation-2")
    before = count(client, app, Response)
    answer = walker.send("questionnaire-1", RATINGS | {"Q1": "1"})
    assert answer.status_code == 409
    assert f'href="{walker.address}"' in answer.text
    assert count(client, app, Response) == before
    assert walker.step() == "explanation-2"


@pytest.mark.parametrize("step", ["comments", "trial-1", "practice", "debrief"])
def test_a_form_for_a_later_step_is_refused_with_a_way_back(walker: Any, step: str) -> None:
    answer = walker.send(step)
    assert answer.status_code == 409
    assert f'href="{walker.address}"' in answer.text
    assert walker.step() == "consent"


def test_a_step_played_in_the_world_cannot_be_left_by_a_form(walker: Any) -> None:
    walker.walk_to("practice")
    assert walker.send("practice").status_code == 409
    assert walker.step() == "practice"


def test_a_failed_practice_says_so_and_the_third_ends_with_its_code(
    walker: Any, study: Study
) -> None:
    for tries in (1, 2):
        walker.walk_to("practice")
        walker.end_trial("timed_out")
        assert f"Try {tries} of 3 did not succeed" in walker.page().text
    walker.walk_to("practice")
    walker.end_trial("timed_out")
    page = walker.page()
    assert page.status_code == 200
    assert study.completion_codes["screened-out"] in page.text
    assert walker.send("instructions", {}).status_code in (303, 409)
    assert walker.step() == "screened-out"


@pytest.mark.parametrize("step", PLAN.steps)
def test_withdrawing_is_offered_and_works_at_every_step(
    walker: Any, study: Study, step: str
) -> None:
    walker.walk_to(step)
    assert f'href="{walker.address}/withdraw"' in walker.page().text
    assert "method=" in walker.client.get(f"{walker.address}/withdraw").text
    assert walker.step() == step
    for _ in range(2):
        assert walker.send("withdraw").headers["location"] == walker.address
    page = walker.page().text
    assert study.completion_codes["withdrawn"] in page
    assert "/withdraw" not in page
    assert walker.client.get(f"{walker.address}/withdraw").headers["location"] == walker.address


def test_two_participants_do_not_touch_each_other(join: Callable[[], Any]) -> None:
    first, second = join(), join()
    first.walk_to("demographics")
    assert second.step() == "consent"
    assert first.address != second.address


def test_no_cookies_are_set_for_participants(walker: Any) -> None:
    walker.walk_to("debrief")
    assert dict(walker.client.cookies) == {}
