"""A real server on a free port, for the tests that speak over sockets."""

import asyncio
import socket
from collections.abc import AsyncIterator
from dataclasses import replace

import pytest
import uvicorn
from starlette.applications import Starlette
from starlette.datastructures import Headers
from starlette.routing import WebSocketRoute

from server.live.clock import SystemClock
from server.live.endpoint import LiveEndpoint
from server.live.hall import Hall
from server.live.line import LineProtocol

from .line import Serving
from .stage import SETUP, MemoryDesk


async def be_ready() -> None:
    """The kernels are there already."""


def own_pages(headers: Headers) -> bool:
    return headers.get("origin") in (None, "http://127.0.0.1")


@pytest.fixture(params=[LineProtocol, "websockets-sansio"], ids=["line", "messages"])
async def serving(request: pytest.FixtureRequest) -> AsyncIterator[Serving]:
    names = [f"t-{number}" for number in range(1, 7)]
    setups = [replace(SETUP, trial_id=name, time_scale=4.0) for name in names]
    setups += [replace(SETUP, trial_id="wide", scale="study", condition="full", time_scale=1.0)]
    desk = MemoryDesk(*setups)
    hall = Hall(desk, be_ready, SystemClock())
    app = Starlette(routes=[WebSocketRoute("/p/{token}/live", LiveEndpoint(hall, own_pages))])
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        listener.listen(64)
        config = uvicorn.Config(
            app,
            ws=request.param,
            ws_per_message_deflate=False,
            ws_max_size=8192,
            log_level="error",
            lifespan="off",
            timeout_graceful_shutdown=2,
        )
        server = uvicorn.Server(config)
        server.install_signal_handlers = lambda: None  # type: ignore[attr-defined]
        running = asyncio.create_task(server.serve(sockets=[listener]))
        await hall.start()
        try:
            yield Serving(hall, desk, listener.getsockname()[1])
        finally:
            await hall.stop()
            server.should_exit = True
            await asyncio.wait_for(running, 10)
