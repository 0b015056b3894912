"""Guards one active place per participant over tabs and devices: on forms as on trials."""

from __future__ import annotations

from typing import Any

import pytest
from fastapi import FastAPI
from sqlalchemy import func, select
from starlette.testclient import TestClient

from server.store.tables import Response

CONSENT = {"adult": "yes", "informed": "yes", "agreed": "yes"}
RATINGS = {f"Q{k}": "4" for k in range(1, 7)}


def answers(client: TestClient, app: FastAPI, step: str) -> int:
    async def run() -> int:
        query = select(func.count()).select_from(Response).where(Response.step == step)
        async with app.state.services.database.reading() as session:
            return await session.scalar(query) or 0

    assert client.portal is not None
    return client.portal.call(run)


def test_two_tabs_with_the_same_form_store_it_once(
    walker: Any, client: TestClient, app: FastAPI
) -> None:
    """Whoever sends first is stored; the other is told where the study is and changes nothing."""
    walker.walk_to("questionnaire-1")
    for _ in range(2):
        assert walker.page().status_code == 200
    assert walker.send("questionnaire-1", RATINGS).status_code == 303
    late = walker.send("questionnaire-1", RATINGS | {"Q1": "1"})
    assert late.status_code == 409
    assert f'href="{walker.address}"' in late.text
    assert answers(client, app, "questionnaire-1") == 6


@pytest.mark.parametrize("behind", ["consent", "demographics", "comments"])
def test_a_tab_left_at_another_step_leads_to_the_current_one(walker: Any, behind: str) -> None:
    walker.walk_to("explanation-1")
    assert walker.send(behind, CONSENT | {"Q1": "1"}).status_code in (303, 409)
    assert walker.step() == "explanation-1"
    assert walker.client.get(f"{walker.address}/{behind}").headers["location"] == walker.address


def test_a_tab_opened_during_a_trial_shows_the_trial(walker: Any) -> None:
    """It takes the trial over; the older one is told so (see the tests of rooms)."""
    walker.walk_to("trial-1")
    assert f'data-live="{walker.address}/live"' in walker.page().text
    assert walker.send("explanation-1").status_code in (303, 409)
    assert walker.step() == "trial-1"


def test_a_tab_left_open_after_withdrawing_stores_nothing(
    walker: Any, client: TestClient, app: FastAPI
) -> None:
    walker.walk_to("questionnaire-1")
    walker.send("withdraw")
    assert walker.send("questionnaire-1", RATINGS).status_code == 409
    assert answers(client, app, "questionnaire-1") == 0
    assert walker.step() == "withdrawn"
