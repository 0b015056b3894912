"""A learning run without its server: the expert's page and a socket that speaks the protocol.

A test turns the knobs by POST /knobs: hold back acknowledgements, refuse, drop the line, stay away,
end. What the page sent is read at GET /heard. Argument: the scale of the hall; the port stands in
VARIL_PORT.
"""

from __future__ import annotations

import asyncio
import json
import os
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import uvicorn
from scripted_run import RUN_ID, SEED, SNAPSHOT_TICKS, ScriptedRun
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from server.kernel_cache import open_kernel_cache
from server.live import wire
from server.pages.rendering import CachedFiles, Renderer
from server.security import HEADERS

ROOT = Path(__file__).resolve().parents[2]
DECISION_TICKS = 30


async def send(socket: WebSocket, messages: Iterable[str | bytes]) -> None:
    """Send texts as texts and bytes as bytes."""
    for message in messages:
        if isinstance(message, str):
            await socket.send_text(message)
        else:
            await socket.send_bytes(message)


class FakeRun(ScriptedRun):
    """A scripted run with any number of pages."""

    def __init__(self, scale: str) -> None:
        super().__init__(scale)
        self.sockets: dict[WebSocket, str] = {}
        self.heard: list[dict[str, Any]] = []

    def seat(self, socket: WebSocket, client: str | None) -> None:
        """A page comes, or goes."""
        if client is None:
            self.sockets.pop(socket, None)
        else:
            self.sockets[socket] = client
        self.clients = list(self.sockets.values())

    async def tell(self, *messages: str | bytes) -> None:
        """Send to all pages."""
        for socket in list(self.sockets):
            try:
                await send(socket, messages)
            except (RuntimeError, WebSocketDisconnect):
                self.seat(socket, None)

    async def go(self) -> None:
        """The world at 30 Hz."""
        loop = asyncio.get_running_loop()
        due = loop.time()
        while True:
            due += 1 / 30
            await asyncio.sleep(max(0.0, due - loop.time()))
            if self.knobs.phase != "running" or self.knobs.status != "open":
                continue
            self.step()
            tick = self.world.tick
            if tick % 2 == 0:
                await self.tell(*self.plans(changed_only=True), self.encoder.encode(0))
            if tick % SNAPSHOT_TICKS == 0 and self.lead() is not None:
                homes = self.world.robot_state.tolist().count(6)
                self.pairs += len(self.boxes) - homes
            if tick % DECISION_TICKS == 0:
                await self.tell(self.display(), self.agents(), self.progress())

    async def join(self, socket: WebSocket) -> None:
        """One page's socket."""
        await socket.accept()
        if self.knobs.away:
            await socket.close(1013)
            return
        hello = json.loads(await socket.receive_text())
        client = hello["client"]
        await socket.send_text(self.run(client))
        if self.knobs.status != "open":
            await send(socket, [self.curve(), self.agreement(), self.ended()])
            await socket.close()
            return
        self.seat(socket, client)
        first = [self.welcome(), self.display(), *self.plans(changed_only=False)]
        first += [self.encoder.encode(0), self.phase(), self.agents(), self.progress()]
        await send(socket, [*first, self.curve(), self.agreement()])
        await self.tell(self.experts())
        try:
            while True:
                await self.hear(socket, client, json.loads(await socket.receive_text()))
        except WebSocketDisconnect:
            self.seat(socket, None)
            await self.tell(self.experts())

    async def hear(self, socket: WebSocket, client: str, message: dict[str, Any]) -> None:
        """One message of a page."""
        kind = message["type"]
        if kind == "ping":
            await socket.send_text(wire.encode_pong(message["sent_ms"]))
            return
        self.heard.append({"client": client, **message})
        if kind == "hand_over":
            self.knobs.lead = message["to"]
            await self.tell(self.experts())
        elif kind == "take_lead":
            self.knobs.lead = client
            await self.tell(self.experts())
        elif kind in ("edit", "confirm"):
            await self.take(socket, client, message)

    async def take(self, socket: WebSocket, client: str, message: dict[str, Any]) -> None:
        """Apply, refuse, or ignore what was taken before."""
        seq = message["seq"]
        if self.knobs.refuse:
            refusal = {"type": "refused", "seq": seq, "message": self.knobs.refuse}
            await socket.send_text(wire.encode_text(refusal))
            return
        if seq > self.taken.get(client, 0):
            self.taken[client] = seq
            for agent, on, off in message.get("changes", []):
                self.boxes[agent] = (self.boxes[agent] | on) & ~off
        await socket.send_text(self.agents())
        if not self.knobs.hold:
            await socket.send_text(wire.encode_text({"type": "stored", "seq": seq}))

    async def turn(self, knobs: dict[str, Any]) -> None:
        """Turn knobs; some have an effect at once."""
        drop = knobs.pop("drop", False)
        begin = knobs.pop("next_trial", False)
        if "boxes" in knobs:
            self.boxes = knobs.pop("boxes")
            await self.tell(self.agents())
        for name, value in knobs.items():
            setattr(self.knobs, name, value)
        if begin:
            self.trial += 1
            self.begin()
            await self.tell(self.welcome(), self.display(), self.phase())
        if "iteration" in knobs:
            self.pairs = self.knobs.iteration * 25
            await self.tell(self.progress(), self.curve())
        if "hold" in knobs and not self.knobs.hold:
            for socket, client in list(self.sockets.items()):
                stored = {"type": "stored", "seq": self.taken.get(client, 0)}
                await socket.send_text(wire.encode_text(stored))
        if "phase" in knobs:
            await self.tell(self.phase())
        if {"lead", "others"} & set(knobs):
            await self.tell(self.experts())
        if "agreement" in knobs:
            await self.tell(self.agreement())
        if self.knobs.status != "open":
            await self.tell(self.ended())
        if drop:
            for socket in list(self.sockets):
                self.seat(socket, None)
                await socket.close(1012)


def make_app(scale: str) -> Starlette:
    """The page, its files, its socket, and the knobs."""
    run = FakeRun(scale)
    renderer = Renderer(ROOT / "web")
    address = f"/expert/runs/{RUN_ID}"

    async def show(request: Request) -> Response:
        values = {
            "user": None,
            "address": address,
            "worker_link": request.query_params.get("link"),
            "run": {
                "id": RUN_ID, "short_id": RUN_ID[:6], "scale": scale, "seed": SEED,
                "status": run.knobs.status, "worker": "person", "iteration": run.pairs // 25,
                "iterations": 240, "pairs": run.pairs, "created_at": "2026-11-22 09:14",
                "settings": run.settings.to_json(),
            },
        }  # fmt: skip
        page = renderer.page("expert-run.html", values)
        page.headers.update(HEADERS)
        return page

    async def turn(request: Request) -> Response:
        await run.turn(await request.json())
        return JSONResponse({"tick": run.world.tick})

    async def hear(_: Request) -> Response:
        return JSONResponse({"heard": run.heard, "boxes": run.boxes, "shown": run.shown})

    async def live(socket: WebSocket) -> None:
        await run.join(socket)

    routes = [
        Route(address, show),
        Route("/healthz", lambda _: Response("fine")),
        Route("/knobs", turn, methods=["POST"]),
        Route("/heard", hear),
        WebSocketRoute(f"{address}/live", live),
        Mount("/static", CachedFiles(directory=ROOT / "web/static")),
    ]
    app = Starlette(routes=routes)
    app.state.run = run
    return app


async def serve(scale: str, port: int) -> None:
    """Serve until interrupted."""
    app = make_app(scale)
    config = uvicorn.Config(app, host="127.0.0.1", port=port, log_level="warning", lifespan="off")
    world = asyncio.create_task(app.state.run.go())
    await uvicorn.Server(config).serve()
    world.cancel()


if __name__ == "__main__":
    open_kernel_cache()
    asyncio.run(serve(sys.argv[1], int(os.environ["VARIL_PORT"])))
