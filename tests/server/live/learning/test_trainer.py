"""Guards training in a process of its own: same tables, no delay here, replaced when it dies."""

from __future__ import annotations

import asyncio
import os
import signal
import subprocess
import sys
import time
from collections.abc import AsyncIterator

import numpy as np
import pytest

from server.live.clock import SystemClock
from server.live.learning.trainer import PoolTrainer
from server.live.ticker import Ticker
from study.learning.domains import DOMAINS
from study.learning.training import TrainingOrder, initial_tables, train_tables

LONG_WORK = range(100_000_000)
PROGRAM = """
import asyncio, os
from server.live.learning.trainer import PoolTrainer
async def main():
    print(await PoolTrainer().ask(os.getpid), flush=True)
    os._exit(9)
if __name__ == "__main__":
    asyncio.run(main())
"""


def order(classifier: str = "svm") -> TrainingOrder:
    draws = np.random.default_rng(3)
    counts = tuple(draws.poisson(0.05, (d.states, d.actions)) for d in DOMAINS)
    return TrainingOrder(7, counts, initial_tables(), classifier, "data")


@pytest.fixture
async def trainer() -> AsyncIterator[PoolTrainer]:
    opened = PoolTrainer()
    yield opened
    await opened.stop()


async def test_another_process_trains_the_same_tables(trainer: PoolTrainer) -> None:
    trainer.warm_up()
    assert await trainer.train(order()) == train_tables(order())
    assert await trainer.ask(os.getpid) != os.getpid()
    assert await trainer.ask(os.nice, 0) >= 5


async def test_a_process_that_dies_is_replaced_and_the_order_sent_again(
    trainer: PoolTrainer,
) -> None:
    """Killed while it works, and once more while nothing is to be done."""
    first = await trainer.ask(os.getpid)
    wanted = asyncio.create_task(trainer.train(order("majority")))
    os.kill(first, signal.SIGKILL)
    assert await asyncio.wait_for(wanted, 60) == train_tables(order("majority"))
    second = await trainer.ask(os.getpid)
    assert second != first
    os.kill(second, signal.SIGKILL)
    assert await asyncio.wait_for(trainer.train(order("majority")), 60)


async def test_an_error_in_training_is_tried_again(
    trainer: PoolTrainer, monkeypatch: pytest.MonkeyPatch
) -> None:
    complaints: asyncio.Queue[str] = asyncio.Queue()
    monkeypatch.setattr("server.live.learning.trainer.FIRST_WAIT_S", 0.01)
    monkeypatch.setattr(
        "server.live.learning.trainer.logger.exception",
        lambda text, *words: complaints.put_nowait(text % words),
    )
    hopeless = asyncio.create_task(trainer.train(order("unheard of")))
    for _ in range(2):
        said = await asyncio.wait_for(complaints.get(), 60)
        assert said == "iteration 7 could not be trained; again"
    hopeless.cancel()


async def test_no_tick_waits_for_a_training(trainer: PoolTrainer) -> None:
    """A second and more of hard work elsewhere; here no tick is late by a quarter of that."""
    ticker = Ticker(SystemClock(), lambda room, problem: None)

    class Room:
        ticks = 0

        def advance(self) -> None:
            self.ticks += 1

        def note_late(self, late_s: float) -> None:
            pass

        def note_lag(self, lost_s: float) -> None:
            raise AssertionError(f"{lost_s} s were given up")

    room = Room()
    ticker.add(room)
    ticking = asyncio.create_task(ticker.run())
    started_s = time.perf_counter()
    await trainer.ask(sum, LONG_WORK)
    worked_s = time.perf_counter() - started_s
    ticking.cancel()
    assert worked_s > 0.8
    assert ticker.lateness.worst_s < worked_s / 4
    assert room.ticks > worked_s * 30 * 0.8


def test_the_process_ends_with_a_server_that_was_killed() -> None:
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True)
    assert done.returncode == 9, done.stderr
    process = int(done.stdout)
    until_s = time.monotonic() + 20
    while time.monotonic() < until_s:
        try:
            os.kill(process, 0)
        except ProcessLookupError:
            return
        time.sleep(0.05)
    pytest.fail("the training process outlives its server")
