"""Guards that the live benchmark still measures what it says; its figures are not judged here."""

import pytest

from server.bench import live as bench_live


def test_a_small_run_reports_all_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three real sockets against real rooms and a real database, for a moment."""
    monkeypatch.setattr(bench_live, "WARM_S", 4.0)
    report = bench_live.bench_live(levels=(3,), seconds=1.0)
    (level,) = report["levels"]
    assert (level["trials"], level["running"]) == (3, 3)
    assert 500 < level["wire_bytes_per_s"] < 3000
    assert level["late_p50_ms"] <= level["late_p99_ms"] <= level["late_worst_ms"] + 0.25
    assert set(report["wire"]) == {"varil", "arroch", "crmiar", "none"}
    assert report["machine"]["cores"] >= 1
    assert "uvicorn" in report["versions"]
