"""Guards administrators' pages about policies: what they show, compare, and let be activated."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Callable
from typing import Any

import pytest
from fastapi import FastAPI
from starlette.testclient import TestClient

from server.pages.policy_tables import lay_out_policy
from server.policy_files import shipped_policy
from study.ar.state_names import ROBOT_STATES, STATION_STATES
from study.config import Study
from study.learning.policy import Policy, initial_policy, read_policy
from tests.server.bad_policies import make_policy

SignIn = Callable[[str], TestClient]
TAUGHT, BRED = make_policy("taught", "people", 1), make_policy("bred", "simulated", 2)


@pytest.fixture
def admin(sign_in_as: SignIn) -> TestClient:
    return sign_in_as("admin")


def upload(client: TestClient, policy: Policy) -> str:
    """Upload a policy and return its page's address."""
    files = {"file": ("p.json", policy.to_json().encode(), "application/json")}
    answer = client.post("/admin/policies", files=files)
    assert answer.status_code == 303, answer.text
    return str(answer.headers["location"])


def words(page: str) -> str:
    """The page's text without its tags."""
    return re.sub(r"\s+", " ", html.unescape(re.sub(r"<[^>]+>", " ", page)))


def test_the_list_says_origin_scores_and_use(admin: TestClient, audit: Any) -> None:
    for policy in (TAUGHT, BRED):
        upload(admin, policy)
    page = words(admin.get("/admin/policies").text)
    assert f"taught {TAUGHT.sha256[:12]} from people uploaded" in page
    assert f"bred {BRED.sha256[:12]} simulated people uploaded" in page
    assert "hamming rate 0.0125" in page
    assert f"runs {shipped_policy().name}" in page
    assert "the one that comes with the software" in page
    assert audit() == [
        ("the-admin", "policy uploaded", f"{p.name}, {p.sha256}") for p in (TAUGHT, BRED)
    ]


def test_an_uploaded_policy_comes_back_byte_for_byte(admin: TestClient) -> None:
    address = upload(admin, TAUGHT)
    assert address == f"/admin/policies/{TAUGHT.sha256}"
    answer = admin.get(f"{address}/file.json")
    assert answer.content == TAUGHT.to_json().encode()
    assert "attachment" in answer.headers["content-disposition"]
    assert read_policy(answer.content) == TAUGHT


def test_activating_says_so_everywhere(admin: TestClient, audit: Any) -> None:
    """On the policy's page, in the list, on the study's page, and in the audit."""
    address = upload(admin, BRED)
    for _ in range(2):
        answer = admin.post(f"{address}/activate", data={"study": "demo"})
        assert (answer.status_code, answer.headers["location"]) == (303, address)
    assert "active for demo" in words(admin.get(address).text)
    assert "Study demo (recruiting pilot) runs bred simulated people ." in words(
        admin.get("/admin/policies").text
    )
    assert "runs the policy bred simulated people" in words(admin.get("/admin").text)
    (noted,) = [entry for entry in audit() if entry[1] == "policy activated"]
    assert noted == ("the-admin", "policy activated", f"demo: bred (simulated), {BRED.sha256}")
    assert admin.get(f"{address}/activate").headers["location"] == address


def test_a_live_study_gets_a_simulated_policy_only_after_a_warning(
    admin: TestClient, app: FastAPI, study: Study
) -> None:
    """The form comes back with the reason and a box to tick; the box is needed, not just sent."""
    app.state.services.policies.studies["demo"] = study.revised(recruiting="live")
    address = upload(admin, BRED)
    assert 'name="confirmed"' in admin.get(address).text
    for form in ({"study": "demo"}, {"study": "demo", "confirmed": "no"}):
        refused = admin.post(f"{address}/activate", data=form)
        assert refused.status_code == 422
        assert "was learned from simulated people. Tick the box" in html.unescape(refused.text)
        assert "active for" not in refused.text
    form = {"study": "demo", "confirmed": "yes"}
    assert admin.post(f"{address}/activate", data=form).status_code == 303
    for page in ("/admin", "/admin/policies"):
        assert "recruits live participants, and this policy was learned from simulated" in words(
            admin.get(page).text
        )


def test_no_box_is_shown_where_nothing_is_to_be_confirmed(
    admin: TestClient, app: FastAPI, study: Study
) -> None:
    bred, taught = upload(admin, BRED), upload(admin, TAUGHT)
    assert 'name="confirmed"' not in admin.get(bred).text
    app.state.services.policies.studies["demo"] = study.revised(recruiting="live")
    assert 'name="confirmed"' not in admin.get(taught).text
    assert admin.post(f"{taught}/activate", data={"study": "demo"}).status_code == 303


def test_comparing_marks_and_counts_what_differs(admin: TestClient) -> None:
    base = initial_policy()
    robots = [7] * 144
    for changed in (0, 77, 143):
        robots[changed] = 4
    other = Policy("other", "initial", base.thresholds, tuple(robots), (1,) * 17 + (0,))
    first, second = upload(admin, base), upload(admin, other)
    page = admin.get(f"{first}?compare={other.sha256}").text
    assert "3 of 144 states differ" in page
    assert "1 of 18 states differ" in page
    marked = re.findall(r'<td class="differs" title="([^"]+)"', page)
    assert sorted(marked) == sorted(
        [ROBOT_STATES[0], ROBOT_STATES[77], ROBOT_STATES[143], STATION_STATES[17]]
    )
    alone = admin.get(second).text
    assert "states differ" not in words(alone)
    assert f'value="{base.sha256}"' in alone
    assert f'value="{other.sha256}"' not in alone


def test_every_state_stands_once_in_its_place_with_its_action() -> None:
    """Rows and columns name exactly the values of which the state's name is made."""
    policy = Policy(
        "p",
        "initial",
        initial_policy().thresholds,
        tuple(n % 8 for n in range(144)),
        tuple(n % 2 for n in range(18)),
    )
    places = (("human", "task", "left", "wait", "near", "viz"), ("human", "wait", "robots"))
    rows_of = (("task", "left", "human"), ("human",))
    tables = ((ROBOT_STATES, policy.robot_table), (STATION_STATES, policy.station_table))
    for matrix, names, down, (states, table) in zip(
        lay_out_policy(policy, None), places, rows_of, tables, strict=True
    ):
        seen = {cell.state: cell.action for _, cells in matrix.rows for cell in cells}
        assert seen == dict(zip(states, table, strict=True))
        heads = [[text for text, span in groups for _ in range(span)] for _, groups in matrix.head]
        for row, cells in matrix.rows:
            for column, cell in enumerate(cells):
                parts = dict(zip(names, cell.state.split("/"), strict=True))
                assert row == tuple(parts.pop(name) for name in down)
                assert list(parts.values()) == [head[column] for head in heads]


def test_cells_say_in_words_what_their_marks_show(admin: TestClient) -> None:
    address = upload(admin, make_policy("p", "people", 6))
    page = admin.get(address).text
    said = set(re.findall(r'class="visually-hidden">([^<]*)</span>', page))
    assert said == {"trajectory, transparent avatar", "nothing"}


def test_versions_of_one_run_have_a_page_of_their_own(admin: TestClient) -> None:
    run = (
        admin.post(
            "/expert/runs",
            data={
                "scale": "small",
                "worker": "simulated",
                "iterations": "5",
                "seed": "1",
                "box_mode": "follow",
                "label_source": "boxes",
                "pair_unit": "agent",
                "beta": "linear",
                "classifier": "svm",
            },
        )
        .headers["location"]
        .rsplit("/", 1)[1]
    )
    page = admin.get(f"/admin/policies?run={run}")
    assert (page.status_code, f"of run {run[:6]}" in words(page.text)) == (200, True)
    assert admin.get("/admin/policies?run=nonsense").status_code == 404


def test_scores_and_settings_of_the_file_are_shown(admin: TestClient) -> None:
    page = words(admin.get(upload(admin, BRED)).text)
    assert "This policy was learned from simulated people" in page
    assert json.loads(BRED.to_json())["training"]["data_sha256"] in page
    assert "settings iterations 240" in page
    assert "habits (wish inform, replaced (none))" in page
    assert "scores before it hamming rate 0.0125" in page
    assert "libraries numpy 2.4" in page
    assert "close m 5.0" in page
