"""Guards `varil replay`: it finds every changed bit, and what another policy would have shown."""

from __future__ import annotations

import asyncio
import csv
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import text

from server.cli.main import app, run_command
from server.policy_files import shipped_policy
from server.replay.run import load_trial, replay_trial
from server.settings import Settings
from server.store.engine import Database
from server.store.schema import migrate
from study.ar.elements import Display
from study.ar.shares import DisplayShares
from study.ar.thresholds import Thresholds
from study.errors import PolicyError
from study.files.demo import paper_study
from study.learning.policy import initial_policy
from tests.server.export.site import MakeResult, Site


@pytest.fixture
def played(settings: Settings, make_result: MakeResult) -> tuple[Settings, str]:
    """A server's settings and a trial of the condition varil that was played to its end."""

    async def run() -> str:
        database = Database(settings.database)
        await migrate(database)
        study = paper_study().revised(scale="practice", conditions=("varil",))
        site = Site(database, study, make_result)
        trial_id = await site.play(await site.walk(6, "4", ""))
        await database.close()
        return trial_id

    return settings, asyncio.run(run())


def change(url: str, statement: str) -> None:
    async def run() -> None:
        database = Database(url)
        async with database.writing() as session:
            await session.execute(text(statement))
        await database.close()

    asyncio.run(run())


def call(words: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[int, Any, str]:
    """Exit code, the last line of stdout as JSON, and stderr of a call within this process."""
    code = run_command(lambda **options: app(words, **options))
    said = capsys.readouterr()
    lines = said.out.strip().splitlines()
    return code, json.loads(lines[-1]) if lines else None, said.err


def test_a_stored_trial_verifies(played: tuple[Settings, str], capsys) -> None:
    settings, trial_id = played
    words = ["replay", trial_id, "--verify", "--json", "--database-url", settings.database]
    code, found, _ = call(words, capsys)
    assert code == 0
    assert set(found) == {"trial", "ticks", "hashes_checked", "mismatches"}
    assert (found["trial"], found["mismatches"]) == (trial_id, 0)
    assert found["hashes_checked"] == -(-found["ticks"] // 30) + 1, "each second and the end"


def test_one_changed_bit_of_a_hash_or_an_input_is_found(
    played: tuple[Settings, str], capsys
) -> None:
    settings, trial_id = played
    words = ["replay", trial_id, "--verify", "--json", "--database-url", settings.database]
    hash_ = "UPDATE trial_chunks SET hashes = x'1E0000000102030405060708' WHERE first_tick = 1"
    change(settings.database, hash_)
    code, found, _ = call(words, capsys)
    assert (code, found["mismatches"] > 0) == (1, True)
    shorter = "UPDATE trial_chunks SET inputs = substr(inputs, 1, length(inputs) - 1)"
    change(settings.database, shorter)
    code, _, said = call(words, capsys)
    assert code == 1
    assert "the stored inputs are damaged" in said


def test_a_lost_end_of_the_journal_is_found(played: tuple[Settings, str], capsys) -> None:
    """What is left of it is sound, but the trial went on."""
    settings, trial_id = played
    last = "(SELECT max(first_tick) FROM trial_chunks)"
    change(settings.database, f"DELETE FROM trial_chunks WHERE first_tick = {last}")
    words = ["replay", trial_id, "--verify", "--json", "--database-url", settings.database]
    code, found, _ = call(words, capsys)
    assert (code, found["mismatches"]) == (1, 1)


def test_what_another_policy_would_have_shown(played: tuple[Settings, str], tmp_path: Path) -> None:
    """The policy that ran shows what was shown; one that shows nothing differs wherever it did."""
    settings, trial_id = played
    stored = asyncio.run(load_trial(settings, trial_id))
    same = replay_trial(stored, shipped_policy(), None)
    assert same["policy_sha256"] == same["ran_policy_sha256"]
    elements = ("trajectory", "live_location", "transparent_avatar", "balloon", "minimap")
    assert {same[f"differs_{name}"] for name in elements} == {0.0}
    assert all(same[f"shown_{name}"] == same[f"policy_{name}"] for name in elements)
    assert any(same[f"shown_{name}"] > 0.05 for name in elements)
    nothing = initial_policy()
    nothing = replace(
        nothing,
        name="nothing",
        robot_table=(0,) * len(nothing.robot_table),
        station_table=(0,) * len(nothing.station_table),
    )
    trace = tmp_path / "trace.csv"
    other = replay_trial(stored, nothing, trace)
    assert (other["policy_trajectory"], other["policy_balloon"]) == (0.0, 0.0)
    assert all(other[f"differs_{name}"] == other[f"shown_{name}"] for name in elements)
    rows = list(csv.DictReader(trace.open()))
    bodies = {row["body"] for row in rows}
    assert {"person", "robot-0", "station-3"} <= bodies
    ticks = sorted({int(row["tick"]) for row in rows})
    assert ticks == list(range(0, other["ticks"] + 1, 6))
    assert {row["policy_would_show"] for row in rows} == {"0"}


def test_a_policy_for_other_borders_is_refused(played: tuple[Settings, str]) -> None:
    settings, trial_id = played
    stored = asyncio.run(load_trial(settings, trial_id))
    with pytest.raises(PolicyError, match="made for other state borders: close_m"):
        replay_trial(stored, initial_policy(Thresholds(close_m=4.0)), None)


def test_an_unknown_or_unplayed_trial_is_told(played: tuple[Settings, str], capsys) -> None:
    settings, trial_id = played
    address = ["--database-url", settings.database]
    assert "there is no trial “nope”" in call(["replay", "nope", *address], capsys)[2]
    change(settings.database, "DELETE FROM trial_chunks")
    assert "has no stored inputs" in call(["replay", trial_id, *address], capsys)[2]


def test_shares_are_over_all_agents_and_the_whole_time() -> None:
    shares = DisplayShares(robots=2, stations=4)
    some, none = Display(bytes([4, 5]), bytes([1, 0, 0, 0]), 2), Display.nothing(2, 4)
    for _ in range(3):
        shares.add(some, none)
    shares.add(none, none)
    found = shares.summary()
    assert (found["shown_trajectory"], found["shown_live_location"]) == (0.75, 0.375)
    assert (found["shown_balloon"], found["shown_offscreen_arrows"]) == (0.1875, 0.75)
    assert found["differs_trajectory"] == 0.75
    assert DisplayShares(2, 4).summary() == {}
