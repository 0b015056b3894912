"""Where headless work runs: in processes of this machine (`loky`) or on a Dask cluster (`dask`).

Both are given the same pieces and yield the same results, in whatever order they finish.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from importlib import import_module
from typing import Any, TypeVar

from joblib import Parallel, delayed

from study.errors import InvalidValue

BACKENDS = ("loky", "dask")
WAIT_S = 30
Piece = TypeVar("Piece")
Result = TypeVar("Result")


class NoCluster(InvalidValue):
    """The Dask cluster that was asked for cannot be used."""


@dataclass(frozen=True)
class Backend:
    """Where to run. `scheduler`: address of a Dask scheduler; "" = a cluster of this machine's.

    `processes` counts worker processes here; a cluster elsewhere has its own.
    """

    name: str = "loky"
    processes: int = 1
    scheduler: str = ""

    def __post_init__(self) -> None:
        if self.name not in BACKENDS:
            raise InvalidValue(
                f"there is no backend “{self.name[:40]}”",
                next_step=f"Use one of: {', '.join(BACKENDS)}.",
            )
        if self.scheduler and self.name != "dask":
            raise InvalidValue(
                f"the backend {self.name} has no scheduler",
                where="--dask-scheduler",
                next_step="Add --backend dask, or leave the address out.",
            )

    def run(self, work: Callable[[Piece], Result], pieces: Sequence[Piece]) -> Iterator[Result]:
        """Yield work(piece) of every piece as they finish.

        Errors: NoCluster when Dask is not installed, does not answer or has no worker.
        """
        if self.name == "dask":
            yield from _run_on_dask(self, work, pieces)
            return
        processes = max(1, min(self.processes, len(pieces)))
        run = Parallel(n_jobs=processes, backend="loky", return_as="generator_unordered")
        yield from run(delayed(work)(piece) for piece in pieces)


def _run_on_dask(
    backend: Backend, work: Callable[[Piece], Result], pieces: Sequence[Piece]
) -> Iterator[Result]:
    try:
        distributed: Any = import_module("distributed")
    except ImportError as missing:
        raise NoCluster(
            "Dask is not installed",
            where="--backend dask",
            next_step="Install it with: .venv/bin/uv sync --locked --inexact --extra dask",
        ) from missing
    with ExitStack() as stack:
        client = _connect(distributed, backend, stack)
        futures = client.map(work, pieces, pure=False, retries=1)
        try:
            done = distributed.as_completed(futures, loop=client.loop, with_results=True)
            for _, result in done:
                yield result
        except distributed.KilledWorker as killed:
            raise NoCluster(
                f"a Dask worker died again and again ({killed})",
                next_step="Give the workers more memory, or use fewer of them on one machine.",
            ) from killed
        finally:
            client.cancel(futures)


def _connect(distributed: Any, backend: Backend, stack: ExitStack) -> Any:
    """A client of the cluster that was asked for, closed with the stack."""
    address = backend.scheduler
    if not address:
        cluster = distributed.LocalCluster(
            n_workers=backend.processes,
            threads_per_worker=1,
            processes=True,
            host="127.0.0.1",
            dashboard_address=None,
            silence_logs=40,
        )
        address = stack.enter_context(cluster).scheduler_address
    try:
        client = distributed.Client(address, timeout=WAIT_S, set_as_default=False)
        stack.enter_context(client)
        client.wait_for_workers(1, timeout=WAIT_S)
    except (OSError, TimeoutError, ValueError) as problem:
        raise NoCluster(
            f"no Dask cluster with a worker answers at {address} ({problem})",
            where="--dask-scheduler",
            next_step="Start one with `dask scheduler` and `dask worker ADDRESS`, "
            "or leave the address out for a cluster on this machine.",
        ) from problem
    return client
