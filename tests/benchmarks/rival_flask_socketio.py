"""The same world served as such servers usually are, measured beside ours in one run.

    .venv/bin/uv run --group bench python -m tests.benchmarks.rival_flask_socketio

Flask-SocketIO in its default mode without an extra event library (threads, simple-websocket): one
loop of 30 steps a second per room, state as JSON 15 times a second. It stores nothing, decides
nothing and sends no paths: all of that it is spared. Both servers have one core; the clients, the
walk they send and the way lateness is counted are the same.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import socket
import sys
import threading
import time
from importlib.metadata import version
from multiprocessing.connection import Connection
from typing import Any

from server.bench.clients import BenchClient, run_clients
from server.bench.live import bench_live
from server.bench.wire import record_walk
from server.kernel_cache import open_kernel_cache
from server.live.lateness import Lateness
from study.warehouse.halls import PRESETS
from study.warehouse.layout import build_layout
from study.warehouse.world import World

PORT_WAIT_S = 30.0
WARM_S = 3.0
PERIOD_S = 1 / 30
SOCKETS = "/socket.io/?EIO=4&transport=websocket"
GOOD_P99_MS = 10.0


class SocketIoClient(BenchClient):
    """The same participant in Socket.IO's dialect."""

    def data_received(self, data: bytes) -> None:
        self.received_bytes += len(data)
        if self._state == "handshake" and b"\r\n\r\n" in data:
            self._state = "connect"
            self._send(1, b"40")
        elif self._state == "connect" and b'40{"sid"' in data:
            self._state, self.is_running = "running", True
        elif data.startswith(b"\x81\x012"):
            self._send(1, b"3")

    def send_frame(self) -> None:
        if self.is_running:
            keys, yaw = self._walk[self._seq % len(self._walk)]
            self._seq += 1
            record = {"seq": self._seq, "keys": keys, "yaw": yaw}
            self._send(1, f'42["input",{json.dumps(record)}]'.encode())


def serve_rival(port: int, control: Connection) -> None:
    """Entry of the rival's process, on the first core."""
    import flask
    import flask_socketio

    sys.stdout = sys.stderr  # Flask greets on stdout, where our report goes
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    open_kernel_cache()
    app = flask.Flask("rival")
    server = flask_socketio.SocketIO(app, async_mode="threading")
    rooms = RivalRooms(server)
    server.on_event("connect", lambda: rooms.open(flask.request.sid))  # type: ignore[attr-defined]
    server.on_event(
        "input",
        lambda record: rooms.take(flask.request.sid, record),  # type: ignore[attr-defined]
    )
    threading.Thread(target=rooms.answer, args=(control,), daemon=True).start()
    server.run(app, "127.0.0.1", port, allow_unsafe_werkzeug=True, log_output=False)


class RivalRooms:
    """One thread per room, each a loop with deadlines of its own, as absolute as ours."""

    def __init__(self, server: Any) -> None:
        self._server = server
        self._layout = build_layout(PRESETS["study"])
        self._inputs: dict[str, list[tuple[int, int]]] = {}
        self._lateness = Lateness()
        World(self._layout, 1).step([(0, 0)])

    def open(self, sid: str) -> None:
        """A participant is there: the room runs."""
        self._inputs[sid] = []
        self._server.start_background_task(self._run, sid)

    def take(self, sid: str, record: dict[str, int]) -> None:
        """An input frame came."""
        self._inputs[sid].append((record["keys"], record["yaw"]))

    def _run(self, sid: str) -> None:
        world, due_s, waiting = World(self._layout, 1), time.perf_counter(), self._inputs[sid]
        while True:
            due_s += PERIOD_S
            self._server.sleep(max(0.0, due_s - time.perf_counter()))
            self._lateness.add(time.perf_counter() - due_s)
            world.step([waiting.pop(0)] if waiting else [])
            if world.tick % 2 == 0:
                self._server.emit("state", describe(world), to=sid)

    def answer(self, control: Connection) -> None:
        """Say how late ticks were since last asked, and what they cost."""
        cpu_s, at_s = time.process_time(), time.perf_counter()
        while True:
            control.recv()
            lateness, self._lateness = self._lateness, Lateness()
            now_cpu_s, now_s = time.process_time(), time.perf_counter()
            control.send(
                {
                    "ticks": lateness.total,
                    "late_p50_ms": round(lateness.quantile_ms(0.5), 2),
                    "late_p99_ms": round(lateness.quantile_ms(0.99), 2),
                    "server_core_share": round((now_cpu_s - cpu_s) / (now_s - at_s), 3),
                }
            )
            cpu_s, at_s = now_cpu_s, now_s


def describe(world: Any) -> dict[str, Any]:
    """The world's state as JSON servers send it."""
    robots = zip(
        world.robot_x_m.tolist(),
        world.robot_y_m.tolist(),
        world.robot_heading.tolist(),
        world.robot_state.tolist(),
        world.robot_carrying.tolist(),
        strict=True,
    )
    return {
        "tick": world.tick,
        "human": {"x": world.human_x_m, "y": world.human_y_m, "yaw": world.human_yaw},
        "robots": [
            {"x": round(x, 3), "y": round(y, 3), "heading": h, "state": s, "carrying": c}
            for x, y, h, s, c in robots
        ],
    }


def measure_rival(level: int, seconds: float, port: int) -> dict[str, Any]:
    """One level of the rival, in processes of its own."""
    context = multiprocessing.get_context("spawn")
    server_end, rival_end = context.Pipe()
    clients_end, load_end = context.Pipe()
    core = sorted(os.sched_getaffinity(0))[-1]
    server = context.Process(target=serve_rival, args=(port, rival_end), daemon=True)
    load = context.Process(
        target=run_clients, args=(port, record_walk(), load_end, core, SocketIoClient), daemon=True
    )
    server.start()
    load.start()
    try:
        wait_for(port)
        clients_end.send(("add", [SOCKETS] * level))
        clients_end.recv()
        time.sleep(WARM_S)
        figures = []
        for pause_s in (0.0, seconds):
            time.sleep(pause_s)
            clients_end.send(("count", None))
            server_end.send("report")
            figures.append((clients_end.recv(), server_end.recv()))
        (_, before, before_s), (running, after, after_s) = figures[0][0], figures[1][0]
        rate = (after - before) / (after_s - before_s) / max(1, running)
        return {"trials": level, "running": running, "wire_bytes_per_s": round(rate)} | figures[1][
            1
        ]
    finally:
        clients_end.send(("stop", None))
        server.kill()
        load.join(10)
        server.join(10)


def wait_for(port: int) -> None:
    """Until somebody listens; TimeoutError after half a minute."""
    end_s = time.perf_counter() + PORT_WAIT_S
    while time.perf_counter() < end_s:
        with socket.socket() as probe:
            if probe.connect_ex(("127.0.0.1", port)) == 0:
                return
        time.sleep(0.1)
    raise TimeoutError(f"nothing listens on port {port}")


def capacity(levels: list[dict[str, Any]]) -> int:
    """The most trials with p99 lateness below 10 ms and every tick made."""
    return max((v["trials"] for v in levels if v["late_p99_ms"] < GOOD_P99_MS), default=0)


def main() -> None:
    """Both servers, level by level in turn; one JSON object on stdout."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--ours", type=int, nargs="+", default=[100, 200, 300])
    parser.add_argument("--rival", type=int, nargs="+", default=[10, 20, 30, 40])
    parser.add_argument("--seconds", type=float, default=8.0)
    given = parser.parse_args()
    open_kernel_cache()
    rival = [measure_rival(n, given.seconds, 18200 + k) for k, n in enumerate(given.rival)]
    ours = bench_live(given.ours, given.seconds)
    summary = {
        "ours": ours["levels"],
        "rival": rival,
        "capacity": {"ours": capacity(ours["levels"]), "rival": capacity(rival)},
        "machine": ours["machine"],
        "versions": ours["versions"] | {"flask-socketio": version("flask-socketio")},
    }
    print(json.dumps(summary, indent=1))


if __name__ == "__main__":
    main()
