"""People of a study on a database, walked or played as far as told, and their export."""

from __future__ import annotations

import csv
import hashlib
import io
import zipfile
from collections.abc import Callable
from itertools import count
from types import SimpleNamespace
from typing import Any, cast

from server.dashboard.watch import LiveWatch
from server.desks.lives import LifeDesk
from server.desks.participants import ParticipantDesk
from server.desks.staff import AdminDesk
from server.desks.trials import StoredTrialDesk
from server.export.bundle import ExportOptions, stream_export
from server.live.opening import open_room
from server.live.ports import TrialResult
from server.store.engine import Database
from study.config import Study
from tests.server.live.stage import FakeClock, Stage, serve_stations

MakeResult = Callable[..., TrialResult]
NUMBERS = count()
CONSENT = {"adult": "yes", "informed": "yes", "agreed": "yes"}
DEVICE = {"keyboard": "yes", "mouse": "yes", "webgl": "yes", "touch_only": "no"}
PERSON = {"age": "31", "gender": "man", "games_3d": "daily", "colour_vision": "no"}


async def export(database: Database, **options: Any) -> bytes:
    """The whole zip."""
    stream = stream_export(database, ExportOptions("demo", **options))
    return b"".join([piece async for piece in stream])


def read_tables(data: bytes) -> dict[str, list[Any]]:
    """The rows of every table, after every file was held against the manifest."""
    with zipfile.ZipFile(io.BytesIO(data)) as bundle:
        assert bundle.testzip() is None
        for line in bundle.read("MANIFEST.sha256").decode().splitlines():
            digest, name = line.split("  ")
            assert hashlib.sha256(bundle.read(name)).hexdigest() == digest
        return {
            name.removesuffix(".csv"): list(
                csv.DictReader(io.StringIO(bundle.read(name).decode(), newline=""))
            )
            for name in bundle.namelist()
            if name.endswith(".csv")
        }


class Site:
    """People of a study on a database, walked as far as told."""

    def __init__(self, database: Database, study: Study, make_result: MakeResult) -> None:
        self.people = ParticipantDesk(database, {"demo": study}, b"k" * 32)
        self.desk = StoredTrialDesk(database)
        self.make_result = make_result
        self.staff = LifeDesk(database)
        nothing_runs = LiveWatch(cast("Any", SimpleNamespace(rooms={})))
        self.admin = AdminDesk(database, cast("Any", None), nothing_runs, 1.0)
        self.database = database

    async def walk(self, steps: int, rating: str, remark: str) -> str:
        token = await self.people.join("demo", "", {"PROLIFIC_PID": f"panel-id-{next(NUMBERS)}"})
        for _ in range(steps):
            step = (await self.people.look_up(token)).participant.progress.page
            if step == "practice" or step.startswith("trial-"):
                opened = await self.desk.open_trial(token)
                await self.desk.finish(opened.setup.trial_id, self.make_result())
                continue
            forms = {
                "consent": CONSENT,
                "browser-check": DEVICE,
                "demographics": PERSON,
                "comments": {"remarks": remark},
            }
            ratings = {f"Q{k}": rating for k in range(1, 7)}
            form = ratings if step.startswith("questionnaire") else forms.get(step, {})
            await self.people.submit(token, step, form)
        return token

    async def play(self, token: str) -> str:
        """Play the current trial to its end, journal and all; returns its id."""
        opened = await self.desk.open_trial(token)
        clock = FakeClock()
        stage = Stage(await open_room(opened, clock), clock)
        stage.join()
        while stage.room.result is None:
            stage.play(5.0, serve_stations)
            batch = stage.room.take_batch()
            if batch is not None:
                await self.desk.commit([batch])
        await self.desk.finish(opened.setup.trial_id, stage.room.result)
        return opened.setup.trial_id
