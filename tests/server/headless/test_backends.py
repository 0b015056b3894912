"""Guards where headless work runs: a Dask cluster gives the same bytes as our own processes."""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import pytest

from server.headless import trials as simulation
from server.headless.backends import Backend, NoCluster
from server.headless.trials import SimulationOptions, run_simulation
from study.errors import InvalidValue

ROOT = Path(__file__).parents[3]


@pytest.fixture(autouse=True)
def _kernels(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VARIL_CACHE_DIR", str(ROOT / "var" / "kernels"))


def options(out: Path, backend: Backend) -> SimulationOptions:
    return SimulationOptions(
        out, condition="full", scale="small", worker="believer", trials=6, seed=50,
        backend=backend, quiet=True,
    )  # fmt: skip


def test_dask_gives_the_same_bytes_as_loky(tmp_path: Path) -> None:
    """A real local cluster of two worker processes, the believer and its display."""
    summaries = [
        run_simulation(options(tmp_path / name, Backend(name, 2))) for name in ("loky", "dask")
    ]
    for table in ("trials.csv", "robots.csv"):
        loky = (tmp_path / "loky" / table).read_bytes()
        assert (tmp_path / "dask" / table).read_bytes() == loky
    with (tmp_path / "dask" / "trials.csv").open() as file:
        assert [row["seed"] for row in csv.DictReader(file)] == [str(n) for n in range(50, 56)]
    for timed in ("wall_s", "steps_per_s_per_core"):
        for summary in summaries:
            del summary[timed]
    assert summaries[0] == summaries[1]


def test_missing_dask_is_told_with_the_command(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(NoCluster, match="--extra dask"):
        list(Backend("dask", 2).run(str, [1]))


def test_a_cluster_that_does_not_answer_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.headless.backends.WAIT_S", 1)
    with pytest.raises(NoCluster, match=r"tcp://127.0.0.1:9 .*dask scheduler"):
        list(Backend("dask", 2, "tcp://127.0.0.1:9").run(str, [1]))


def test_wrong_words_are_refused() -> None:
    with pytest.raises(InvalidValue, match="loky, dask"):
        Backend("threads")
    with pytest.raises(InvalidValue, match="Add --backend dask"):
        Backend("loky", 2, "tcp://127.0.0.1:8786")


def test_a_worker_of_another_version_is_not_believed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The kernels' digest differs here from the one that the processes report."""
    monkeypatch.setattr(simulation, "kernel_digest", lambda: "other")
    with pytest.raises(NoCluster, match="another version"):
        run_simulation(options(tmp_path / "out", Backend(processes=2)))
    assert not (tmp_path / "out" / "trials.csv").exists()
