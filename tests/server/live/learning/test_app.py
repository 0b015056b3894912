"""Guards learning runs in the whole server: sockets, database, sign-in, a training process."""

from __future__ import annotations

import asyncio
import contextlib
import json
import shutil
import socket
from collections.abc import AsyncIterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
import uvicorn
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from server.app import create_app
from server.desks.learning import RunRequest
from server.live.learning.trainer import PoolTrainer
from server.live.line import LineProtocol
from server.settings import Settings
from server.signin import COOKIE
from server.store.users import find_user, store_user
from study.files.demo import paper_study
from study.learning.settings import LearningSettings
from tests.server.live.learning.lab import ANNA, BEN

SHORT = LearningSettings(iterations=1, classifier="majority", seed=3)
LONG = LearningSettings(iterations=200, seed=3)
WITHIN_S = 60


def hello(client: str = ANNA, last_seq: int = 0, version: int = 1) -> str:
    words = {"type": "hello", "version": version, "client": client, "last_seq": last_seq}
    return json.dumps(words)


class Site:
    """The app on a free port, as `varil serve` runs it, four times as fast."""

    def __init__(self, settings: Settings) -> None:
        self.app = create_app(settings, [paper_study()])
        self.services = self.app.state.services
        self.cookie = ""
        self.port = 0

    async def sign_in(self) -> None:
        async with self.services.database.writing() as session:
            user = await find_user(session, "anna")
            if user is None:
                await store_user(session, "anna", "expert", "unusable", datetime.now(UTC))
                user = await find_user(session, "anna")
        assert user is not None
        self.cookie = f"{COOKIE}={self.services.sign_ins.sign(user)}"

    async def new_run(self, settings: LearningSettings, worker: Any = "simulated") -> Any:
        return await self.services.learning.create_run(
            RunRequest("small", settings, worker), "anna"
        )

    def connect(self, path: str, *, signed_in: bool = True, **headers: str) -> connect:
        given = {"Cookie": self.cookie} if signed_in else {}
        address = f"ws://127.0.0.1:{self.port}{path}"
        return connect(address, compression=None, additional_headers={**given, **headers})


@contextlib.asynccontextmanager
async def serve(settings: Settings) -> AsyncIterator[Site]:
    site = Site(settings)
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        listener.listen(16)
        site.port = listener.getsockname()[1]
        config = uvicorn.Config(
            site.app,
            ws=LineProtocol,
            ws_per_message_deflate=False,
            ws_max_size=8192,
            log_config=None,
            timeout_graceful_shutdown=3,
        )
        server = uvicorn.Server(config)
        running = asyncio.create_task(server.serve(sockets=[listener]))
        while not server.started:
            assert not running.done()
            await asyncio.sleep(0.01)
        await site.sign_in()
        try:
            yield site
        finally:
            server.should_exit = True
            await asyncio.wait_for(running, 30)


@pytest.fixture
async def settings(
    tmp_path: Path, migrated_file: Path, monkeypatch: pytest.MonkeyPatch
) -> Settings:
    async def compile_nothing(folder: Path) -> None:
        del folder

    monkeypatch.setattr("server.app.prepare_kernels", compile_nothing)
    monkeypatch.setattr("server.live.learning.room.CHECK_EVERY_S", 0.2)
    monkeypatch.setattr(PoolTrainer, "warm_up", lambda self: None)
    settings = Settings(var_dir=tmp_path / "var", time_scale=4.0)
    settings.var_dir.mkdir()
    shutil.copy(migrated_file, settings.var_dir / "varil.sqlite3")
    return settings


async def read(ws: ClientConnection, kind: str, **wanted: Any) -> dict[str, Any]:
    """The next text of this type with these values."""
    async with asyncio.timeout(WITHIN_S):
        while True:
            frame = await ws.recv()
            if isinstance(frame, str):
                text: dict[str, Any] = json.loads(frame)
                assert text["type"] != "error", text
                if text["type"] == kind and wanted.items() <= text.items():
                    return text


async def read_close(ws: ClientConnection) -> int | None:
    with contextlib.suppress(ConnectionClosed):
        async with asyncio.timeout(WITHIN_S):
            while True:
                await ws.recv()
    return ws.close_code


async def test_a_whole_run_with_a_real_training(settings: Settings) -> None:
    """From the first edit to the learned policy in the database."""
    async with serve(settings) as site:
        run_id, _ = await site.new_run(SHORT)
        async with site.connect(f"/expert/runs/{run_id}/live") as ws:
            await ws.send(hello())
            run = await read(ws, "run")
            assert run["you"] == {"name": "anna", "client": ANNA}
            await read(ws, "phase", phase="running")
            agents = await read(ws, "agents")
            edit = {"seq": 1, "trial": 0, "tick": agents["tick"], "changes": [[0, 0, 3]]}
            await ws.send(json.dumps({"type": "edit", **edit}))
            assert (await read(ws, "agents"))["boxes"][0] == 4
            await read(ws, "stored", seq=1)
            curve = await read(ws, "curve", **{"from": 0})
            assert len(curve["lines"]["policy"]["off_rate"]) == 1
            await read(ws, "ended", status="finished")
            assert await read_close(ws) == 1000
        stored = await site.services.learning.read_run_summary(run_id)
        assert (stored.status, stored.pairs, stored.iteration) == ("finished", 25, 1)
        opened = await site.services.learning.open_run(run_id)
        assert opened.versions[1].policy.origin == "people"
        assert opened.trial_ended
        async with site.connect(f"/expert/runs/{run_id}/live") as ws:
            await ws.send(hello(BEN))
            await read(ws, "ended", status="finished")
            assert await read_close(ws) == 1000


async def test_a_restarted_server_goes_on_with_the_same_run(settings: Settings) -> None:
    """The page sends again what was not acknowledged; the server takes each number once."""
    async with serve(settings) as site:
        run_id, _ = await site.new_run(LONG)
        async with site.connect(f"/expert/runs/{run_id}/live") as ws:
            await ws.send(hello())
            agents = await read(ws, "agents", tick=90)
            for seq in (1, 2):
                edit = {"seq": seq, "trial": 0, "tick": agents["tick"], "changes": [[seq, 0, 2]]}
                await ws.send(json.dumps({"type": "edit", **edit}))
            await read(ws, "stored", seq=2)
            before = await read(ws, "progress", tick=240)
    async with serve(settings) as site, site.connect(f"/expert/runs/{run_id}/live") as ws:
        await ws.send(hello(last_seq=2))
        assert (await read(ws, "run"))["taken_seq"] == 2
        assert await read(ws, "stored") == {"type": "stored", "seq": 2}
        assert (await read(ws, "experts"))["lead"] == ANNA
        agents = await read(ws, "agents")
        assert agents["tick"] >= 240
        assert agents["boxes"][:4] == [7, 5, 5, 7]
        assert (await read(ws, "progress"))["pairs"] >= before["pairs"] == 20
        edit = {"seq": 2, "trial": 0, "tick": agents["tick"], "changes": [[0, 0, 7]]}
        await ws.send(json.dumps({"type": "edit", **edit}))
        await read(ws, "stored", seq=2)
        await read(ws, "phase", phase="running")
        assert (await read(ws, "agents"))["boxes"][0] == 7


async def test_a_person_works_while_an_expert_watches_until_the_run_is_stopped(
    settings: Settings,
) -> None:
    async with serve(settings) as site:
        run_id, token = await site.new_run(LONG, "person")
        async with (
            site.connect(f"/expert/runs/{run_id}/live") as expert,
            site.connect(f"/w/{token}/live", signed_in=False) as worker,
        ):
            await expert.send(hello())
            await read(expert, "phase", phase="waiting")
            await worker.send(json.dumps({"type": "hello", "version": 1}))
            assert (await read(worker, "welcome"))["kind"] == "learning"
            await worker.send(json.dumps({"type": "ready"}))
            await read(worker, "phase", phase="running")
            await read(expert, "phase", phase="running")
            await site.services.learning.stop_run(run_id, "anna")
            await read(expert, "ended", status="stopped")
            assert await read_close(expert) == 4410
            assert await read_close(worker) == 4410
        async with site.connect(f"/w/{token}/live", signed_in=False) as worker:
            await worker.send(json.dumps({"type": "hello", "version": 1}))
            assert await read_close(worker) == 4410


async def test_doors(settings: Settings) -> None:
    """Who may not come, and what cannot be read, is told so by the code."""
    async with serve(settings) as site:
        run_id, _ = await site.new_run(LONG)
        path = f"/expert/runs/{run_id}/live"
        first: list[tuple[str, bool, list[str | bytes], int]] = [
            (path, False, [hello()], 4403),
            ("/expert/runs/" + "f" * 32 + "/live", True, [hello()], 4401),
            ("/w/" + "x" * 32 + "/live", True, ['{"type":"hello","version":1}'], 4401),
            (path, True, ["no json"], 4400),
            (path, True, [b"\x01\x01"], 4400),
            (path, True, [hello(version=2)], 4400),
            (path, True, [hello(), hello()], 4400),
            (path, True, ['{"type":"take_lead"}'], 4400),
            (path, True, ['{"type":"ping","sent_ms":1}', hello("tom")], 4400),
            (path, True, [" " * 4097], 1009),
            (path, True, ['{"type":"ping","sent_ms":1}'] * 200, 4400),
        ]
        for place, signed_in, frames, code in first:
            async with site.connect(place, signed_in=signed_in) as ws:
                with contextlib.suppress(ConnectionClosed):
                    for frame in frames:
                        await ws.send(frame)
                assert await read_close(ws) == code, frames[-1][:60]
        with pytest.raises(InvalidStatus):
            await site.connect(path, Origin="http://elsewhere.example")
        # A page that knows the number of somebody else's page does not get its lead.
        async with site.services.database.writing() as session:
            await store_user(session, "ben", "expert", "unusable", datetime.now(UTC))
            ben = await find_user(session, "ben")
        assert ben is not None
        async with site.connect(path) as anna:
            await anna.send(hello())
            await read(anna, "progress")
            site.cookie = f"{COOKIE}={site.services.sign_ins.sign(ben)}"
            async with site.connect(path) as ws:
                await ws.send(hello())
                assert await read_close(ws) == 1013
            await read(anna, "progress")
