"""Training in another process, so that no tick waits for it.

The process is started afresh (not forked off a server with threads), kept warm, gives way to the
ticks, and ends by itself when the server is gone. One that dies is replaced and the order is sent
again.
"""

from __future__ import annotations

import asyncio
import logging
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.context import SpawnContext, SpawnProcess
from typing import Any, Protocol, TypeVar

import numpy as np

from study.learning.domains import DOMAINS
from study.learning.training import Tables, TrainingOrder, initial_tables, train_tables

logger = logging.getLogger(__name__)

T = TypeVar("T")
NICENESS = 5
FIRST_WAIT_S = 0.5
LONGEST_WAIT_S = 60.0


class Trainer(Protocol):
    """Fills training orders somewhere else."""

    def warm_up(self) -> None:
        """An order may come soon."""
        ...

    async def train(self, order: TrainingOrder) -> Tables:
        """The tables for an order; tries until there are any."""
        ...

    async def stop(self) -> None:
        """No order will come any more."""
        ...


class PoolTrainer:
    """Trains in one process of its own, order by order."""

    def __init__(self) -> None:
        self._context = _Context()
        self._pool: ProcessPoolExecutor | None = None
        self._lock = threading.Lock()
        self._warming: asyncio.Task[None] | None = None

    def warm_up(self) -> None:
        """Start the process and let it load what it trains with."""
        if self._warming is None or (self._warming.done() and self._pool is None):
            self._warming = asyncio.get_running_loop().create_task(self._warm_up())

    async def train(self, order: TrainingOrder) -> Tables:
        """The tables for an order; a process that dies or fails is tried again, ever later."""
        wait_s = 0.0
        while True:
            try:
                return await self.ask(train_tables, order)
            except BrokenProcessPool:
                logger.warning("the training process died; iteration %d again", order.iteration)
            except Exception:
                logger.exception("iteration %d could not be trained; again", order.iteration)
                wait_s = max(wait_s, FIRST_WAIT_S)
            await asyncio.sleep(wait_s)
            wait_s = min(LONGEST_WAIT_S, max(FIRST_WAIT_S, 2 * wait_s))

    async def ask(self, work: Callable[..., T], *words: Any) -> T:
        """What a function gives in the training process. Raises BrokenProcessPool, or its error."""
        pool, future = await asyncio.to_thread(self._submit, work, *words)
        try:
            return await asyncio.wrap_future(future)
        except BrokenProcessPool:
            self._drop(pool)
            raise

    async def stop(self) -> None:
        """End the process, whatever it does; orders under way are given up."""
        if self._warming is not None:
            self._warming.cancel()
            await asyncio.gather(self._warming, return_exceptions=True)
        await asyncio.to_thread(self._end)

    async def _warm_up(self) -> None:
        try:
            await self.ask(load_libraries)
        except Exception:
            logger.exception("the training process could not be warmed up; it starts when needed")

    def _submit(self, work: Callable[..., T], *words: Any) -> tuple[ProcessPoolExecutor, Future[T]]:
        """In a thread of its own: starting a process takes longer than a tick may."""
        with self._lock:
            if self._pool is None:
                self._pool = ProcessPoolExecutor(
                    max_workers=1,
                    mp_context=self._context,
                    initializer=settle_down,
                )
            pool = self._pool
            try:
                return pool, pool.submit(work, *words)
            except BrokenProcessPool:
                self._pool = None
                raise

    def _end(self) -> None:
        with self._lock:
            pool, self._pool = self._pool, None
            if pool is not None:
                pool.shutdown(wait=False, cancel_futures=True)
                self._context.kill_all()

    def _drop(self, pool: ProcessPoolExecutor) -> None:
        with self._lock:
            if self._pool is pool:
                self._pool = None
        pool.shutdown(wait=False, cancel_futures=True)


class _Context(SpawnContext):
    """Starts processes afresh and knows them, so that they can be ended at any time."""

    def __init__(self) -> None:
        super().__init__()
        self._known: list[SpawnProcess] = []

    def Process(self, *args: Any, **kwargs: Any) -> SpawnProcess:  # type: ignore[override]  # noqa: N802
        process = SpawnProcess(*args, **kwargs)
        self._known = [known for known in self._known if known.is_alive()] + [process]
        return process

    def kill_all(self) -> None:
        """End every process that was started here."""
        for process in self._known:
            if process.is_alive():
                process.kill()


def settle_down() -> None:
    """In the training process: give way, leave the keyboard to the server, end with it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(os, "nice"):
        os.nice(NICENESS)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent,), daemon=True).start()


def load_libraries() -> None:
    """In the training process: train something small, so that everything is loaded."""
    counts = tuple(np.zeros((domain.states, domain.actions), np.int64) for domain in DOMAINS)
    for table in counts:
        table[0, 0] = table[1, 1] = 1
    train_tables(TrainingOrder(1, counts, initial_tables(), "svm", ""))


def _end_with(parent: Any) -> None:
    parent.join()
    os._exit(0)
