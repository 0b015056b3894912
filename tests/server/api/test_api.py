"""Guards `/api/v1`: what it says, its pages, its problems, and that nothing sent makes it fail."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any
from urllib.parse import quote

import pytest
from fastapi import FastAPI
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from starlette.testclient import TestClient

from server.api.description import ROUTERS, describe_api

SignIn = Callable[[str], TestClient]
AS_JSON = {"content-type": "application/json"}
TEXTS = st.text(max_size=30) | st.sampled_from(["demo", "P-XXXXXXXX", "bot", "live", "0" * 64])
LEAVES = (
    st.none() | st.booleans() | st.integers() | st.floats() | TEXTS
)  # fmt: skip
JSON = st.recursive(
    LEAVES,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(TEXTS, inner, max_size=4),
    max_leaves=8,
)
OPERATIONS = [
    (method.upper(), path, operation)
    for path, methods in describe_api()["paths"].items()
    for method, operation in methods.items()
]


def test_the_description_names_every_route(sign_in_as: SignIn) -> None:
    """All that is there, with problems as records; no secret among what is answered."""
    document = sign_in_as("admin").get("/api/v1/openapi.json").json()
    routes = {(m, r.path) for one in ROUTERS for r in one.routes for m in r.methods}  # type: ignore[attr-defined]
    assert {(method, path) for method, path, _ in OPERATIONS} == routes
    assert document["openapi"].startswith("3.1")
    fields = document["components"]["schemas"]["Participant"]["properties"]
    assert {"code", "mode", "is_bot"} <= set(fields)
    assert not {"token", "token_hash", "panel_ids"} & set(fields)
    for _, _, operation in OPERATIONS:
        assert "application/problem+json" in operation["responses"]["404"]["content"]


def test_studies_tell_their_counts_and_definition(walker: Any, sign_in_as: SignIn) -> None:
    walker.walk_to("practice")
    admin = sign_in_as("admin")
    [summary] = admin.get("/api/v1/studies").json()
    mode = summary["recruiting"]
    assert (summary["study_id"], summary["counts"]) == ("demo", {mode: {"active": 1}})
    detail = admin.get("/api/v1/studies/demo").json()
    assert detail["definition"]["study_id"] == "demo"
    assert len(detail["orders"]) == 6


def test_lists_are_paged_and_filtered(join: Callable[[], Any], sign_in_as: SignIn) -> None:
    """Every row once over all pages; what is asked for by study, mode, status and person."""
    walkers = [join() for _ in range(3)]
    walkers[1].walk_to("trial-1")
    admin = sign_in_as("admin")
    pages = [
        admin.get("/api/v1/participants", params={"offset": k, "limit": 2}).json() for k in (0, 2)
    ]
    assert [page["total"] for page in pages] == [3, 3]
    codes = [one["code"] for page in pages for one in page["items"]]
    assert len(set(codes)) == 3
    active = admin.get("/api/v1/participants", params={"status": "active"}).json()
    assert [one["code"] for one in active["items"]] == [codes[1]]
    assert admin.get("/api/v1/participants", params={"mode": "bot"}).json()["total"] == 0
    trials = admin.get("/api/v1/trials", params={"participant": codes[1]}).json()["items"]
    assert [trial["kind"] for trial in trials] == ["practice"]
    one = admin.get(f"/api/v1/trials/{trials[0]['trial_id']}").json()
    assert one == trials[0]


def test_excluding_and_reinstating_need_a_reason(walker: Any, sign_in_as: SignIn) -> None:
    walker.walk_to("explanation-1")
    admin = sign_in_as("admin")
    code = admin.get("/api/v1/participants").json()["items"][0]["code"]
    path = f"/api/v1/participants/{code}"
    assert admin.post(f"{path}/exclude", json={}).status_code == 422
    told = admin.post(f"{path}/exclude", json={"reason": "spoke to others"}).json()
    assert (told["status"], told["changes"][-1]["actor"]) == ("excluded", "the-admin")
    again = admin.post(f"{path}/reinstate", json={"reason": "a mistake"}).json()
    assert again["status"] == "active"
    assert admin.post(f"{path}/reinstate", json={"reason": "again"}).status_code == 409


def test_policies_are_listed_and_read(sign_in_as: SignIn) -> None:
    admin = sign_in_as("admin")
    listed = admin.get("/api/v1/policies").json()["items"]
    assert listed[0]["source"] == "shipped"
    document = admin.get(f"/api/v1/policies/{listed[0]['sha256']}").json()
    assert document["name"] == listed[0]["name"]


def test_the_export_is_a_zip(sign_in_as: SignIn) -> None:
    answer = sign_in_as("admin").get("/api/v1/studies/demo/export", params={"mode": "bot"})
    assert (answer.status_code, answer.content[:2]) == (200, b"PK")


@pytest.mark.parametrize(
    ("path", "status"),
    [
        ("/api/v1/studies/none", 404),
        ("/api/v1/participants/P-0", 404),
        ("/api/v1/trials/0", 404),
        ("/api/v1/policies/0", 404),
        ("/api/v1/nothing", 404),
        ("/api/v1/participants?limit=0", 422),
        ("/api/v1/participants/%00", 422),
        ("/api/v1/trials?participant=%00", 422),
        ("/api/v1/participants?mode=all", 422),
    ],
)
def test_problems_say_what_happened_and_what_next(
    sign_in_as: SignIn, path: str, status: int
) -> None:
    answer = sign_in_as("admin").get(path)
    body = answer.json()
    assert answer.headers["content-type"] == "application/problem+json"
    assert (answer.status_code, body["status"]) == (status, status)
    assert body["title"]
    assert body["detail"]
    assert body["next_step"]


@pytest.mark.parametrize(
    ("method", "path", "operation"),
    [o for o in OPERATIONS if "export" not in o[1]],
    ids=lambda part: part if isinstance(part, str) else "",
)
def test_nothing_sent_makes_it_fail(
    sign_in_as: SignIn, app: FastAPI, method: str, path: str, operation: dict[str, Any]
) -> None:
    """Any path, query and body: an answer as described, or a problem; never a 5xx."""
    admin = sign_in_as("admin")
    names = {"path": [], "query": []}
    for parameter in operation.get("parameters", ()):
        names[parameter["in"]].append(parameter["name"])
    properties = _properties(operation)
    bodies = JSON | st.fixed_dictionaries({}, optional=dict.fromkeys(properties, JSON))

    @settings(
        max_examples=25,
        deadline=None,
        derandomize=True,
        database=None,
        suppress_health_check=list(HealthCheck),
    )
    @given(st.data())
    def send(data: st.DataObject) -> None:
        places = {name: data.draw(TEXTS.filter(_stands_in_a_path)) for name in names["path"]}
        query = {name: data.draw(TEXTS | st.integers()) for name in names["query"]}
        body = {}
        if "requestBody" in operation:
            body = {"content": json.dumps(data.draw(bodies)), "headers": AS_JSON}
        address = path.format(**{name: quote(place, safe="") for name, place in places.items()})
        answer = admin.request(method, address, params=query, **body)
        assert answer.status_code < 500, (address, query, body, answer.text)
        if answer.status_code >= 400:
            assert answer.json()["next_step"]

    send()


def _stands_in_a_path(text: str) -> bool:
    return bool(text.strip(". /"))


def _properties(operation: dict[str, Any]) -> list[str]:
    if "requestBody" not in operation:
        return []
    schema = operation["requestBody"]["content"]["application/json"]["schema"]
    name = schema["$ref"].rsplit("/", 1)[1]
    return list(describe_api()["components"]["schemas"][name]["properties"])
