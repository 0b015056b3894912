"""A participant who can be walked through the pages, and trials that end as told."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, Literal

import pytest
from fastapi import FastAPI
from starlette.testclient import TestClient

from server.live.ports import TrialResult
from server.signin import COOKIE
from server.store.audit import AuditWanted, search_audit
from server.store.users import find_user, store_user
from study.warehouse.measures import Leg, RobotMeasures, TrialMeasures

Status = Literal["completed", "timed_out", "abandoned"]
MakeResult = Callable[..., TrialResult]

CONSENT = {"adult": "yes", "informed": "yes", "agreed": "yes"}
DEVICE = {
    "keyboard": "yes",
    "mouse": "yes",
    "webgl": "yes",
    "touch_only": "no",
    "frame_rate_hz": "59.94",
    "latency_ms": "12",
}
PERSON = {"age": "31", "gender": "woman", "games_3d": "never", "colour_vision": "no"}
RATINGS = {"Q1": "5", "Q2": "4", "Q3": "3", "Q4": "2", "Q5": "1", "Q6": "5"}


@pytest.fixture
def make_result() -> MakeResult:
    """Results of trials with two robots, all figures different."""

    def make(status: Status = "completed", ticks: int = 3000) -> TrialResult:
        robots = tuple(
            RobotMeasures(k, 3, 10.5 + k, 90.25 + k, 50.125 + k, 1.5 + k, 0.5 + k) for k in (0, 1)
        )
        legs = (
            Leg(0, 0, "to_shelf", 0.0, 3.5, 3.25, 1, 12, -1, True),
            Leg(0, 1, "waiting", 3.5, 9.0, 0.0, -1, 12, 2, True),
            Leg(1, 0, "to_shelf", 0.0, 4.0, 4.0, 2, 30, -1, False),
        )
        measures = TrialMeasures(
            status, ticks, ticks / 30, 6, 22.0, 181.5, 91.25, 80.5, 5.25, 1.0, 2.5, 0, robots, legs
        )
        return TrialResult(status, ticks, b"\x01" * 8, datetime.now(UTC), measures)

    return make


@dataclass
class Walker:
    """One participant with a browser, and a world that ends when told."""

    client: TestClient
    app: FastAPI
    make_result: MakeResult
    address: str

    @property
    def token(self) -> str:
        return self.address.rsplit("/", 1)[1]

    def page(self) -> Any:
        return self.client.get(self.address)

    def send(self, step: str, form: dict[str, str] | None = None) -> Any:
        return self.client.post(f"{self.address}/{step}", data=form or {})

    def heading(self) -> str:
        found = re.search(r"<h1>(.*?)</h1>|<title>(.*?) ·", self.page().text, re.DOTALL)
        assert found is not None
        return (found[1] or found[2]).strip()

    def end_trial(self, status: Status = "completed") -> str:
        """Open the current trial and bring it to its end; returns its id."""
        desk = self.app.state.services.trials

        async def run() -> str:
            opened = await desk.open_trial(self.token)
            await desk.finish(opened.setup.trial_id, self.make_result(status))
            return str(opened.setup.trial_id)

        assert self.client.portal is not None
        return self.client.portal.call(run)

    def walk_to(self, wanted: str) -> None:
        """Go on until the current step is `wanted`; every form must be accepted."""
        forms = {"consent": CONSENT, "browser-check": DEVICE, "demographics": PERSON}
        while (step := self.step()) != wanted:
            assert step != "debrief", f"the step {wanted} never came"
            if step == "practice" or step.startswith("trial-"):
                self.end_trial()
                continue
            form = RATINGS if step.startswith("questionnaire-") else forms.get(step, {})
            answer = self.send(step, form)
            assert answer.status_code == 303, f"{step}: {answer.status_code}\n{answer.text}"

    def step(self) -> str:
        """The current step, from the database."""
        assert self.client.portal is not None
        visit = self.client.portal.call(self.app.state.services.participants.look_up, self.token)
        return str(visit.participant.progress.page)


@pytest.fixture
def join(client: TestClient, app: FastAPI, make_result: MakeResult) -> Callable[[], Walker]:
    """Lets one more participant join the demo study."""

    def joined() -> Walker:
        answer = client.post("/s/demo", data={})
        assert answer.status_code == 303
        return Walker(client, app, make_result, answer.headers["location"])

    return joined


@pytest.fixture
def walker(join: Callable[[], Walker]) -> Walker:
    """A participant who has just joined."""
    return join()


@pytest.fixture
def sign_in_as(client: TestClient, app: FastAPI) -> Callable[[str], TestClient]:
    """Signs a new account of the given role in, named after it; no password is hashed."""

    def signed_in(role: Any) -> TestClient:
        services = app.state.services

        async def store() -> str:
            async with services.database.writing() as session:
                await store_user(session, f"the-{role}", role, "unusable", datetime.now(UTC))
                user = await find_user(session, f"the-{role}")
            assert user is not None
            return str(services.sign_ins.sign(user))

        assert client.portal is not None
        client.cookies.set(COOKIE, client.portal.call(store))
        return client

    return signed_in


@pytest.fixture
def audit(client: TestClient, app: FastAPI) -> Callable[[], list[tuple[str, str, str]]]:
    """What was written down of staff, oldest first: (who, what, detail)."""

    async def read() -> list[tuple[str, str, str]]:
        async with app.state.services.database.reading() as session:
            found, _ = await search_audit(session, AuditWanted(), offset=0, limit=100)
            return [entry[1:] for entry in reversed(found)]

    def listed() -> list[tuple[str, str, str]]:
        assert client.portal is not None
        return client.portal.call(read)

    return listed
