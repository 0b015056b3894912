"""`varil bench live`: how many participants' trials one core carries, and what they cost.

The server runs as it does in a study: real worlds at `study` scale, agents' decisions, journal,
SQLite, uvicorn with uvloop, one core. Another process holds the participants' sockets, each with
30 input frames a second and 15 snapshots back. The number of trials is raised step by step; for
each step the lateness of ticks is reported. Wire bytes are also counted exactly, over a whole
trial in simulated time.
"""

from __future__ import annotations

import asyncio
import multiprocessing
import os
import socket
import tempfile
import time
from collections.abc import AsyncIterator, Collection, Sequence
from contextlib import asynccontextmanager
from dataclasses import asdict, dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from server.bench.clients import run_clients
from server.bench.machine import describe_machine
from server.bench.wire import measure_wire, record_walk
from server.desks.trials import StoredTrialDesk
from server.kernel_cache import kernel_folder
from server.live.clock import SystemClock
from server.live.compiling import choose_cache, load_kernels, settle_memory
from server.live.endpoint import LiveEndpoint
from server.live.hall import Hall
from server.live.lateness import Lateness
from server.live.line import LineProtocol
from server.live.ports import OpenTrial, TrialBatch, TrialResult, TrialSetup
from server.policy_files import shipped_policy
from server.store.bench import add_bench_trials
from server.store.engine import Database
from server.store.schema import migrate
from study.warehouse.halls import PRESETS

LIBRARIES = ("numba", "numpy", "starlette", "uvicorn", "uvloop", "websockets")
WARM_S = 6.0


@dataclass(frozen=True)
class Level:
    """What was measured with so many trials. Shares are of one core."""

    trials: int
    running: int
    seconds: float
    late_p50_ms: float
    late_p99_ms: float
    late_worst_ms: float
    lost_s: float
    server_core_share: float
    wire_bytes_per_s: float
    slowest_commit_ms: float


class BenchDesk:
    """Opens trials from memory, stores them like a study's."""

    def __init__(self, stored: StoredTrialDesk, setups: dict[str, TrialSetup]) -> None:
        self._stored = stored
        self._setups = setups

    async def open_trial(self, token: str) -> OpenTrial:
        """The trial of this token, from its start."""
        return OpenTrial(self._setups[token])

    async def commit(self, batches: Sequence[TrialBatch]) -> Collection[str]:
        """As in a study."""
        return await self._stored.commit(batches)

    async def finish(self, trial_id: str, result: TrialResult) -> None:
        """Nobody moves on."""


def bench_live(
    levels: Sequence[int] = (100, 200, 300, 400), seconds: float = 15.0
) -> dict[str, Any]:
    """Run the benchmark; returns the report. Takes about half a minute per level."""
    import uvloop

    load_kernels(choose_cache(kernel_folder()))
    with tempfile.TemporaryDirectory() as folder:
        measured = uvloop.run(_measure(tuple(levels), seconds, Path(folder)))
    return {
        "benchmark": "live",
        "scale": "study",
        "condition": "varil",
        "levels": [asdict(level) for level in measured],
        "wire": {name: measure_wire(name) for name in ("varil", "arroch", "crmiar", "none")},
    } | describe_machine(LIBRARIES)


async def _measure(levels: Sequence[int], seconds: float, folder: Path) -> list[Level]:
    database = Database(f"sqlite:///{folder / 'bench.sqlite3'}")
    await migrate(database)
    setups = _make_setups(max(levels))
    await add_bench_trials(database, list(setups.values()))
    settle_memory()
    desk = BenchDesk(StoredTrialDesk(database), setups)
    cores = sorted(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {cores[0]})
    try:
        async with _serving(desk) as (hall, port), _clients(port, cores[-1]) as control:
            measured = []
            tokens = list(setups)
            for before, level in zip((0, *levels), levels, strict=False):
                paths = [f"/p/{token}/live" for token in tokens[before:level]]
                measured.append(await _measure_level(hall, control, paths, level, seconds))
            return measured
    finally:
        os.sched_setaffinity(0, set(cores))
        await database.close()


async def _measure_level(
    hall: Hall, control: Connection, paths: list[str], level: int, seconds: float
) -> Level:
    await _ask(control, "add", paths)
    await asyncio.sleep(WARM_S)
    _, bytes_before, before_s = await _ask(control, "count", None)
    hall.ticker.lateness = lateness = Lateness()
    hall.writer.slowest_commit_s = 0.0
    cpu_s = time.process_time()
    await asyncio.sleep(seconds)
    running, bytes_after, after_s = await _ask(control, "count", None)
    return Level(
        trials=level,
        running=sum(room.phase == "running" for room in hall.rooms.values()),
        seconds=seconds,
        late_p50_ms=lateness.quantile_ms(0.50),
        late_p99_ms=lateness.quantile_ms(0.99),
        late_worst_ms=round(lateness.worst_s * 1000, 2),
        lost_s=round(lateness.lost_s, 3),
        server_core_share=round((time.process_time() - cpu_s) / seconds, 3),
        wire_bytes_per_s=round((bytes_after - bytes_before) / (after_s - before_s) / running, 1),
        slowest_commit_ms=round(hall.writer.slowest_commit_s * 1000, 1),
    )


async def _ask(control: Connection, word: str, value: object) -> Any:
    control.send((word, value))
    return await asyncio.to_thread(control.recv)


@asynccontextmanager
async def _serving(desk: BenchDesk) -> AsyncIterator[tuple[Hall, int]]:
    import uvicorn
    from starlette.applications import Starlette
    from starlette.routing import WebSocketRoute

    async def ready_already() -> None:
        """The kernels were loaded before."""

    hall = Hall(desk, ready_already, SystemClock())
    endpoint = LiveEndpoint(hall, lambda headers: True)
    app = Starlette(routes=[WebSocketRoute("/p/{token}/live", endpoint)])
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        listener.listen(1024)
        config = uvicorn.Config(
            app,
            ws=LineProtocol,
            ws_per_message_deflate=False,
            ws_ping_interval=None,  # one ping in 20 s costs nothing; the clients do not answer it
            lifespan="off",
            log_level="error",
            timeout_graceful_shutdown=2,
        )
        server = uvicorn.Server(config)
        running = asyncio.create_task(server.serve(sockets=[listener]))
        await hall.start()
        try:
            yield hall, listener.getsockname()[1]
        finally:
            await hall.stop()
            server.should_exit = True
            await running


@asynccontextmanager
async def _clients(port: int, core: int) -> AsyncIterator[Connection]:
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    walk = record_walk()
    process = context.Process(target=run_clients, args=(port, walk, theirs, core), daemon=True)
    process.start()
    try:
        yield ours
    finally:
        ours.send(("stop", None))
        await asyncio.to_thread(process.join, 10)


def _make_setups(count: int) -> dict[str, TrialSetup]:
    policy = shipped_policy()
    return {
        f"bench-{number}": TrialSetup(
            trial_id=f"bench{number:04}",
            kind="trial",
            scale="study",
            spec=PRESETS["study"],
            seed=1,
            condition="varil",
            policy=policy,
            label="Display A",
            mode="pilot",
        )
        for number in range(count)
    }
