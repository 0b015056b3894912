"""Guards that the benches of learning and of headless trials still measure what they say."""

from __future__ import annotations

from pathlib import Path

import pytest

from server.bench.headless import measure_headless
from server.bench.learn import measure_learning
from study.errors import InvalidValue
from study.learning.settings import LearningSettings

ROOT = Path(__file__).parents[3]


@pytest.fixture(autouse=True)
def _kernels(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VARIL_CACHE_DIR", str(ROOT / "var" / "kernels"))


def test_learning_reports_all_figures() -> None:
    report = measure_learning(2, "table", LearningSettings(iterations=20, seed=1))
    assert (report["iterations"], report["pairs"], len(report["wall_s_all"])) == (20, 500, 2)
    assert report["wall_s_median"] > 0
    training = report["training"]
    assert (training["all_rows"], len(training["all_ms_all"])) == (500, 2)
    assert training["different_rows"] < 200
    assert training["ratio"] > 0
    assert "scikit-learn" in report["versions"]
    with pytest.raises(InvalidValue, match="no expert"):
        measure_learning(1, "oracle")


def test_headless_reports_all_figures() -> None:
    report = measure_headless(repeats=1, trials=1, table_trials=1, workers=1)
    steps = report["steps"]
    assert set(steps["per_s_per_core_median"]) == {"believer_with_policy", "cyclic"}
    assert min(steps["per_s_per_core_median"].values()) > 1000
    assert (report["table"]["policies"], report["table"]["trials"]) == (6, 6)
    assert len(report["table"]["wall_s_all"]) == 1
    assert report["machine"]["cores"] >= 1
