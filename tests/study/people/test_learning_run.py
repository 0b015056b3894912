"""Guards whole learning runs with simulated experts, through the command's own door."""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from server.headless.learning import DATASET_FIELDS, LearningOptions, learn
from server.policy_files import read_policy_file
from study.ar.state_names import ROBOT_STATES, STATION_STATES
from study.errors import InvalidValue
from study.learning.discrepancies import REFERENCES
from study.learning.settings import LearningSettings
from study.people.learning_run import EXPERTS, run_learning
from study.people.table_expert import robot_answer, station_answer
from study.warehouse.layout import PRESETS, build_layout

ROOT = Path(__file__).parents[3]
SUMMARY = [
    "iterations", "pairs", "expert", "off_rate_first5", "off_rate_last40", "hamming_first5",
    "hamming_last40", "arroch_off_rate_last40", "arroch_hamming_last40", "shown_share_last40",
    "policy_sha256", "wall_s",
]  # fmt: skip


@pytest.fixture(autouse=True)
def _kernels(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VARIL_CACHE_DIR", str(ROOT / "var" / "kernels"))


@pytest.mark.parametrize("seed", [3001, 3002, 3003])
def test_the_table_is_learned(seed: int, tmp_path: Path) -> None:
    """The paper's size: 6000 pairs, nearly no difference at the end, neither all nor nothing."""
    options = LearningOptions(
        tmp_path, LearningSettings(seed=seed), expert="table", worker="believer", quiet=True
    )
    summary = learn(options)
    assert list(summary) == SUMMARY
    assert (summary["iterations"], summary["pairs"]) == (240, 6000)
    assert summary["hamming_last40"] <= 0.02
    assert 0.05 <= summary["shown_share_last40"] <= 0.95
    assert summary["arroch_hamming_last40"] > 10 * summary["hamming_last40"]


def test_the_files_of_a_run(tmp_path: Path) -> None:
    """Every version is a readable policy, and the tables hold what they promise."""
    settings = LearningSettings(iterations=8, seed=5)
    summary = learn(LearningOptions(tmp_path, settings, scale="small", expert="table", quiet=True))
    files = sorted((tmp_path / "policies").iterdir())
    assert [file.name for file in files] == [f"{n:03}.json" for n in range(9)]
    policies = [read_policy_file(file) for file in files]
    assert [policy.origin for policy in policies] == ["initial"] + ["simulated"] * 8
    assert policies[-1].sha256 == summary["policy_sha256"]
    assert policies[3].training is not None
    assert policies[3].training["settings"]["iteration"] == 3
    with (tmp_path / "dataset.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert (len(rows), tuple(rows[0])) == (200, DATASET_FIELDS)
    for row in rows:
        answer = robot_answer if row["agent_kind"] == "robot" else station_answer
        assert int(row["box"]) == answer(row["state"])
    with (tmp_path / "discrepancies.csv").open() as file:
        lines = list(csv.DictReader(file))
    assert {line["line"] for line in lines} == {"policy", *REFERENCES}
    assert len(lines) == 8 * 5
    floor = [line for line in lines if line["line"] == "floor"]
    assert all(float(line["hamming_rate"]) == 0.0 for line in floor)


@pytest.mark.parametrize("expert", EXPERTS)
def test_the_same_seed_gives_the_same_files_in_another_process(expert: str, tmp_path: Path) -> None:
    """Every file of a run repeats itself byte for byte, twice here and once in another process."""
    settings = LearningSettings(iterations=20, seed=77)
    for folder in ("here", "again"):
        options = LearningOptions(tmp_path / folder, settings, "small", expert=expert, quiet=True)
        learn(options)
    words = ["learn", "--iterations", "20", "--seed", "77", "--scale", "small", "--json"]
    people = ["--expert", expert, "--worker", "believer", "--out", str(tmp_path / "there")]
    done = subprocess.run(
        [sys.executable, "-c", "from server.cli.main import main; main()", *words, *people],
        cwd=ROOT,
        env=dict(os.environ, PYTHONHASHSEED="7"),
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert list(json.loads(done.stdout.splitlines()[-1])) == SUMMARY
    for here in (tmp_path / "here").rglob("*.*"):
        for folder in ("again", "there"):
            other = tmp_path / folder / here.relative_to(tmp_path / "here")
            assert here.read_bytes() == other.read_bytes(), other


@pytest.mark.parametrize("classifier", ["per_element", "majority", "cost_sensitive"])
def test_other_classifiers_run(classifier: str) -> None:
    settings = LearningSettings(iterations=6, classifier=classifier)
    up = run_learning(settings, build_layout(PRESETS["small"]), "cyclic", "table")
    robots, stations = up.latest
    assert (up.units, len(robots), len(stations)) == (150, len(ROBOT_STATES), len(STATION_STATES))
    assert (len(set(robots)) == 1) == (classifier == "majority")


def test_unknown_people_are_named() -> None:
    layout = build_layout(PRESETS["practice"])
    with pytest.raises(InvalidValue, match="no worker"):
        run_learning(LearningSettings(), layout, "lazy", "table")
    with pytest.raises(InvalidValue, match="no expert"):
        run_learning(LearningSettings(), layout, "cyclic", "oracle")
    with pytest.raises(InvalidValue, match="no classifier"):
        run_learning(LearningSettings(classifier="forest"), layout, "cyclic", "table")


def test_a_run_with_the_believer_repeats_itself() -> None:
    """The worker who looks at the learned display closes the loop, and still to the bit."""
    settings = LearningSettings(iterations=12, seed=9)
    runs = [
        run_learning(settings, build_layout(PRESETS["small"]), "believer", "table")
        for _ in range(2)
    ]
    assert runs[0].versions == runs[1].versions
    assert runs[0].dataset.pairs == runs[1].dataset.pairs
    other = run_learning(settings, build_layout(PRESETS["small"]), "cyclic", "table")
    assert other.dataset.pairs != runs[0].dataset.pairs
