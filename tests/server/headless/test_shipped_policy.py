"""Guards the shipped policy: one command makes it, and it says that nobody real taught it."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

import pytest

from server.headless.learning import LearningOptions, learn
from server.policy_files import SHIPPED, shipped_policy
from study.learning.settings import LearningSettings

ROOT = Path(__file__).parents[3]


def test_it_is_what_varil_learn_makes_with_seed_1(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`varil learn --seed 1 --out DIR` repeats the file's tables and the hash of its data."""
    monkeypatch.setenv("VARIL_CACHE_DIR", str(ROOT / "var" / "kernels"))
    settings = LearningSettings(seed=1)
    learn(LearningOptions(tmp_path, settings=settings, expert="person", quiet=True))
    made = (tmp_path / "policies" / "240.json").read_text(encoding="utf-8")
    file = resources.files("study.policies").joinpath(SHIPPED)
    assert made == file.read_text(encoding="utf-8"), (
        "the code learns another policy now: make it again with the command in docs/learning.md"
    )


def test_it_is_marked_as_simulated_and_is_neither_all_nor_nothing() -> None:
    policy = shipped_policy()
    assert policy.origin == "simulated"
    assert policy.training is not None
    assert policy.training["settings"]["expert"] == "person"
    assert len(set(policy.robot_table)) > 1
    assert len(set(policy.station_table)) > 1
