"""Guards experts' pages: starting a run, its link for a worker, its downloads, and its end."""

from __future__ import annotations

import csv
import html
import io
import re
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Any

import pytest
from fastapi import FastAPI
from starlette.testclient import TestClient

from server.live.learning.rows import RunVersion
from server.store.learning import add_rows
from server.worker_links import COOKIE
from study.learning.policy import initial_policy, read_policy
from study.learning.settings import LearningSettings
from tests.server.bad_policies import make_policy
from tests.server.learning_lab import rows

SignIn = Callable[[str], TestClient]
FORM = {
    "scale": "small",
    "worker": "person",
    "iterations": "12",
    "seed": "77",
    "box_mode": "independent",
    "label_source": "confirmed",
    "pair_unit": "snapshot",
    "beta": "exponential(0.9)",
    "classifier": "majority",
}


@pytest.fixture
def expert(sign_in_as: SignIn) -> TestClient:
    return sign_in_as("expert")


def start(client: TestClient, **changes: str) -> str:
    """Start a run and return its address."""
    answer = client.post("/expert/runs", data=FORM | changes)
    assert answer.status_code == 303, answer.text
    return str(answer.headers["location"])


def link_on(page: str) -> str:
    """The worker's address on the page of a run."""
    found = re.search(r'href="http://testserver(/w/[\w-]{32})"', page)
    return found[1] if found else ""


def summary(client: TestClient, app: FastAPI, address: str) -> Any:
    desk = app.state.services.learning
    assert client.portal is not None
    return client.portal.call(desk.read_run_summary, address.rsplit("/", 1)[1])


def test_a_run_is_started_as_the_form_says(expert: TestClient, app: FastAPI, audit: Any) -> None:
    address = start(expert)
    assert re.fullmatch(r"/expert/runs/[0-9a-f]{32}", address)
    run = summary(expert, app, address)
    wanted = LearningSettings(
        iterations=12,
        seed=77,
        box_mode="independent",
        label_source="confirmed",
        pair_unit="snapshot",
        beta="exponential(0.9)",
        classifier="majority",
    )
    assert {k: v for k, v in run.settings.items() if k != "thresholds"} == wanted.to_json()
    assert (run.scale, run.worker, run.created_by, run.status) == (
        "small", "person", "the-expert", "open",
    )  # fmt: skip
    assert audit() == [("the-expert", "learning run started", f"{run.id}, small, worker person")]
    listed = expert.get("/expert").text
    assert f'href="{address}"' in listed
    assert "0 of 12" in listed


def test_the_form_as_it_is_first_shown_is_accepted(expert: TestClient, app: FastAPI) -> None:
    """The paper's settings are filled in, and a seed."""
    page = expert.get("/expert").text
    fields = dict(re.findall(r'<input id="(\w+)" name="\w+" value="([^"]*)"', page))
    chosen = re.findall(r'<select id="(\w+)".*?<option value="(\w+)" selected>', page, re.DOTALL)
    run = summary(expert, app, start(expert, **fields, **dict(chosen)))
    assert set(fields) | {name for name, _ in chosen} == set(FORM)
    usual = LearningSettings(seed=run.seed)
    assert {k: v for k, v in run.settings.items() if k != "thresholds"} == usual.to_json()


@pytest.mark.parametrize(
    ("name", "value", "told"),
    [
        ("scale", "castle", "practice, small, study, large, lab"),
        ("worker", "robot", "person, simulated"),
        ("iterations", "0", "a whole number from 1 to 2000"),
        ("iterations", "2001", "a whole number from 1 to 2000"),
        ("iterations", "", "whole number in digits"),
        ("iterations", "1e3", "whole number in digits"),
        ("iterations", "9" * 5000, "whole number in digits"),
        ("iterations", "٣", "whole number in digits"),
        ("seed", "-1", "whole number in digits"),
        ("seed", str(2**53 + 1), "a whole number from 0 to 9007199254740992"),
        ("beta", "cosine", "exponential(p) with p from 0 to 1"),
        ("beta", "exponential(1.5)", "exponential(p) with p from 0 to 1"),
        ("box_mode", "", "follow, independent"),
        ("label_source", "guess", "boxes, events, confirmed"),
        ("pair_unit", "hour", "agent, snapshot"),
        ("classifier", "forest", "svm, per_element, majority, cost_sensitive"),
    ],
)
def test_an_unfit_setting_is_named_and_what_was_typed_stays(
    expert: TestClient, app: FastAPI, name: str, value: str, told: str
) -> None:
    """Beside the field and above the form; no run is started."""
    answer = expert.post("/expert/runs", data=FORM | {name: value})
    page = html.unescape(answer.text)
    assert answer.status_code == 422
    assert re.search(rf'id="{name}-problem">[^<]*{re.escape(told)}', page)
    assert f'href="#{name}"' in page
    assert page.count('class="problem"') == 1
    for other, typed in FORM.items():
        if other != name:
            assert re.search(rf'name="{other}"[^>]* value="{re.escape(typed)}"', page) or (
                f'value="{typed}" selected' in page
            )
    assert "No run was started yet" in page


def test_an_empty_form_names_every_field(expert: TestClient) -> None:
    answer = expert.post("/expert/runs", data=dict.fromkeys(FORM, ""))
    assert answer.status_code == 422
    assert set(re.findall(r'id="(\w+)-problem"', answer.text)) == set(FORM)


def test_the_workers_link_is_shown_once_and_can_be_made_anew(
    expert: TestClient, audit: Any
) -> None:
    address = start(expert)
    first = link_on(expert.get(address).text)
    assert first
    assert link_on(expert.get(address).text) == ""
    assert COOKIE not in expert.cookies
    answer = expert.post(f"{address}/worker-link")
    assert (answer.status_code, answer.headers["location"]) == (303, address)
    flags = answer.headers["set-cookie"].lower()
    assert "httponly" in flags
    assert f"path={address}" in flags
    second = link_on(expert.get(address).text)
    assert second not in ("", first)
    assert expert.get(first).status_code == 404
    assert expert.get(second).status_code == 200
    assert audit()[-1] == ("the-expert", "worker link made", address.rsplit("/", 1)[1])


def test_the_link_of_one_run_is_not_shown_on_another(expert: TestClient) -> None:
    one, other = start(expert), start(expert)
    cookie = next(c for c in expert.cookies.jar if c.name == COOKIE and c.path == other)
    foreign = expert.get(one, headers={"cookie": f"{COOKIE}={cookie.value}"})
    assert link_on(foreign.text) == ""


def test_a_worker_opens_the_warehouse_and_after_the_end_a_word_of_thanks(
    expert: TestClient,
) -> None:
    """Without signing in, and without meeting what the experts see."""
    address = start(expert)
    link = link_on(expert.get(address).text)
    expert.cookies.clear()
    page = expert.get(link).text
    assert f'data-live="{link}/live"' in page
    assert f'data-next="{link}"' in page
    assert "the-expert" not in page


def test_stopping_ends_a_run_for_all(expert: TestClient, app: FastAPI, audit: Any) -> None:
    address = start(expert)
    link = link_on(expert.get(address).text)
    for _ in range(2):
        assert expert.post(f"{address}/stop").headers["location"] == address
    assert summary(expert, app, address).status == "stopped"
    assert "stopped" in expert.get(address).text
    ended = expert.get(link)
    assert (ended.status_code, "run has ended" in ended.text) == (200, True)
    assert expert.post(f"{address}/worker-link").status_code == 409
    assert [what for _, what, _ in audit()] == ["learning run started", "learning run stopped"]


def test_a_simulated_worker_has_no_link(expert: TestClient) -> None:
    address = start(expert, worker="simulated")
    assert link_on(expert.get(address).text) == ""
    assert expert.post(f"{address}/worker-link").status_code == 409


def test_dataset_and_policies_can_be_downloaded(expert: TestClient, app: FastAPI) -> None:
    address = start(expert)
    run_id = address.rsplit("/", 1)[1]
    learned = make_policy("learned", "people")
    services = app.state.services
    initial = read_policy(expert.get(f"{address}/policies/0.json").content)
    assert initial == initial_policy(), "also before anybody opened the run"
    assert expert.get(f"{address}/dataset.csv").text.count("\n") == 1

    async def add() -> None:
        async with services.database.writing() as session:
            given = rows(run_id, 0, 30, versions=(RunVersion(1, learned),))
            await add_rows(session, given, datetime.now(UTC))

    assert expert.portal is not None
    expert.portal.call(add)
    answer = expert.get(f"{address}/dataset.csv")
    assert answer.headers["content-type"].startswith("text/csv")
    assert f"run-{run_id[:6]}-dataset.csv" in answer.headers["content-disposition"]
    stored = list(csv.DictReader(io.StringIO(answer.text)))
    assert {row["origin"] for row in stored} == {"people"}
    assert len(stored) == 30
    policy = expert.get(f"{address}/policies/1.json")
    assert read_policy(policy.content) == learned
    assert f"run-{run_id[:6]}-001.json" in policy.headers["content-disposition"]
    assert expert.get(f"{address}/policies/2.json").status_code == 404
    for nonsense in ("-1", "x", "9" * 30):
        assert expert.get(f"{address}/policies/{nonsense}.json").status_code == 422


def test_the_latest_policy_is_the_newest_that_was_trained(expert: TestClient, app: FastAPI) -> None:
    """A run that is stopped during a training has closed more iterations than it has policies."""
    address = start(expert)
    run_id = address.rsplit("/", 1)[1]
    learned = make_policy("learned", "people")
    assert read_policy(expert.get(f"{address}/policies/latest.json").content) == initial_policy()

    async def add() -> None:
        async with app.state.services.database.writing() as session:
            given = rows(run_id, 0, 60, versions=(RunVersion(1, learned),), iteration=2)
            await add_rows(session, given, datetime.now(UTC))

    assert expert.portal is not None
    expert.portal.call(add)
    expert.post(f"{address}/stop")
    assert summary(expert, app, address).iteration == 2
    page = expert.get(address).text
    (link,) = set(re.findall(r'href="([^"]*/policies/[^"]*)"', page))
    answer = expert.get(link)
    assert read_policy(answer.content) == learned
    assert f"run-{run_id[:6]}-001.json" in answer.headers["content-disposition"]
    assert expert.get(f"/expert/runs/{'0' * 32}/policies/latest.json").status_code == 404


@pytest.mark.parametrize("run_id", ["0" * 32, "nonsense", "%00", "A" * 32])
def test_a_run_that_is_not_here_is_not_found(expert: TestClient, run_id: str) -> None:
    for page in ("", "/dataset.csv", "/policies/0.json"):
        assert expert.get(f"/expert/runs/{run_id}{page}").status_code == 404
    for action in ("stop", "worker-link"):
        assert expert.post(f"/expert/runs/{run_id}/{action}").status_code == 404


@pytest.mark.parametrize("token", ["x" * 32, "nonsense", "%00"])
def test_a_workers_link_that_is_not_known_is_told_as_such(client: TestClient, token: str) -> None:
    answer = client.get(f"/w/{token}")
    assert (answer.status_code, "This link is not known here" in answer.text) == (404, True)


def test_a_list_longer_than_a_page_is_paged(expert: TestClient) -> None:
    for _ in range(51):
        start(expert)
    first, second = expert.get("/expert").text, expert.get("/expert?page=2").text
    assert (first.count('scope="row"'), second.count('scope="row"')) == (50, 1)
    assert "Page 2 of 2" in second
    assert "This page of the list is empty" in expert.get("/expert?page=99").text
