"""Guards policy files: what is written can be read, and nothing damaged is accepted."""

import json
from collections.abc import Callable
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.policy_files import SHIPPED, read_policy_file, shipped_policy
from study.ar.state_names import ROBOT_STATES
from study.ar.thresholds import Thresholds
from study.errors import PolicyError
from study.learning.policy import Policy, initial_policy, read_policy

TRAINING = {"data_sha256": "0" * 64, "settings": {}, "seed": 1, "scores": {}, "libraries": {}}
Record = dict[str, Any]


@given(
    st.lists(st.integers(0, 7), min_size=144, max_size=144),
    st.lists(st.integers(0, 1), min_size=18, max_size=18),
    st.sampled_from([None, TRAINING]),
)
def test_reading_gives_back_what_was_written(
    robots: list[int], stations: list[int], training: Record | None
) -> None:
    """Any policy survives its file, and the file is the same bytes each time."""
    policy = Policy("p", "simulated", Thresholds(), tuple(robots), tuple(stations), training)
    text = policy.to_json()
    again = read_policy(text)
    assert again == policy
    assert again.sha256 == policy.sha256
    assert again.to_json() == text


def test_every_policy_file_of_the_software_is_sound() -> None:
    """Whichever of them ships: it can be read strictly and fits the usual borders."""
    files = sorted(Path(str(resources.files("study.policies"))).glob("*.json"))
    assert SHIPPED in [file.name for file in files]
    for file in files:
        read_policy_file(file).require_thresholds(Thresholds())
    assert shipped_policy() == read_policy_file(Path(files[0]).with_name(SHIPPED))


def test_the_initial_file_switches_everything_on() -> None:
    """The real path: file -> tables, the paper's initial policy."""
    file = Path(str(resources.files("study.policies"))) / "initial.json"
    assert read_policy_file(file) == initial_policy()
    assert set(initial_policy().robot_table) == {7}
    assert set(initial_policy().station_table) == {1}


def test_the_hash_covers_every_part() -> None:
    """Policies that differ anywhere differ in their hash."""
    base = initial_policy()
    variants = [
        base,
        replace(base, name="other"),
        replace(base, robot_table=(6, *base.robot_table[1:])),
        replace(base, station_table=(0, *base.station_table[1:])),
        replace(base, thresholds=Thresholds(close_m=4.0)),
        replace(base, training=TRAINING),
    ]
    assert len({policy.sha256 for policy in variants}) == len(variants)


def drop_state(record: Record) -> None:
    del record["robot_table"]["close/dropping/few/short/few/many"]


def drop_station_state(record: Record) -> None:
    del record["station_table"]["far/long/many"]


def add_state(record: Record) -> None:
    record["robot_table"]["near/dropping/few/short/few/many"] = 1


def wrong_action(record: Record) -> None:
    record["robot_table"][ROBOT_STATES[5]] = 8


def half_action(record: Record) -> None:
    record["robot_table"][ROBOT_STATES[5]] = 3.0


def true_action(record: Record) -> None:
    record["station_table"]["far/long/many"] = True


def wrong_schema(record: Record) -> None:
    record["schema_version"] = 2


def drop_threshold(record: Record) -> None:
    del record["thresholds"]["nearby_m"]


def swapped_thresholds(record: Record) -> None:
    record["thresholds"]["close_m"] = 20.0


def infinite_threshold(record: Record) -> None:
    record["thresholds"]["far_m"] = float("inf")


def nan_threshold(record: Record) -> None:
    record["thresholds"]["far_m"] = float("nan")


def silent_edit(record: Record) -> None:
    record["robot_table"][ROBOT_STATES[0]] = 0


def unknown_origin(record: Record) -> None:
    record["origin"] = "elsewhere"


def table_as_list(record: Record) -> None:
    record["robot_table"] = [7] * 144


def stray_field(record: Record) -> None:
    record["host"] = "lab-3"


def half_training(record: Record) -> None:
    record["training"] = {"seed": 1}


def true_version(record: Record) -> None:
    record["schema_version"] = True


def endless_name(record: Record) -> None:
    record["name"] = "x" * 121


def torn_name(record: Record) -> None:
    record["name"] = "half \ud800"


def no_digest(record: Record) -> None:
    record["training"] = TRAINING | {"data_sha256": "../../etc/passwd"}


def seed_as_text(record: Record) -> None:
    record["training"] = TRAINING | {"seed": "7"}


def score_as_text(record: Record) -> None:
    record["training"] = TRAINING | {"scores": {"off_rate": "good"}}


def torn_settings(record: Record) -> None:
    record["training"] = TRAINING | {"settings": {"expert": "\ud800"}}


@pytest.mark.parametrize(
    ("damage", "sentence"),
    [
        (true_version, r"version True, wanted"),
        (endless_name, r"name: 'x+\.\.\. cannot be a policy's name"),
        (torn_name, r"name: 'half .* cannot be"),
        (no_digest, r"training, data_sha256: '../../etc/passwd' is no SHA-256"),
        (seed_as_text, r"training, seed: '7' is no seed"),
        (score_as_text, r"training, scores: 'good' is not allowed for “off_rate”"),
        (torn_settings, r"training: it holds something that no file can hold"),
        (drop_state, r"robot_table: “close/dropping/few/short/few/many” is missing"),
        (drop_station_state, r"station_table: “far/long/many” is missing"),
        (add_state, r"“near/dropping/few/short/few/many” is not known"),
        (wrong_action, r"robot_table, close/picking/few/medium/few/many: the action 8"),
        (half_action, r"the action 3\.0 is not allowed"),
        (true_action, r"the action True is not allowed"),
        (wrong_schema, r"version 2, wanted 'varil-policy' version 1"),
        (drop_threshold, r"thresholds: “nearby_m” is missing"),
        (swapped_thresholds, r"close_m \(20\.0\) must be below far_m"),
        (infinite_threshold, r"Infinity is no number"),
        (nan_threshold, r"NaN is no number"),
        (silent_edit, r"sha256: the file says"),
        (unknown_origin, r"origin: 'elsewhere' is not known"),
        (table_as_list, r"robot_table: an object with an action for each state"),
        (stray_field, r"“host” is not known"),
        (half_training, r"training: “data_sha256”, “settings”, “scores” and 1 more are missing"),
    ],
)
def test_damaged_files_are_refused_by_name(damage: Callable[[Record], None], sentence: str) -> None:
    """Each refusal names the place and what is wrong there."""
    record = json.loads(initial_policy().to_json())
    damage(record)
    with pytest.raises(PolicyError, match=sentence):
        read_policy(json.dumps(record))


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "no JSON"),
        ("[]", "one JSON object"),
        ("{", "no JSON"),
        ("[" * 100_000, "no JSON"),
        (b"\xff\xfe\x00", "no JSON"),
        ('{"schema": "varil-policy", "schema": "varil-policy"}', "“schema” is given twice"),
    ],
    ids=["empty", "list", "cut", "deep", "bytes", "twice"],
)
def test_what_is_no_policy_at_all(text: str | bytes, sentence: str) -> None:
    with pytest.raises(PolicyError, match=sentence):
        read_policy(text)


def test_other_thresholds_are_named() -> None:
    """A study refuses a policy made for other borders and hears which differ."""
    policy = initial_policy(Thresholds(nearby_m=4.0, many_tasks=3))
    policy.require_thresholds(Thresholds(nearby_m=4.0, many_tasks=3))
    with pytest.raises(PolicyError, match=r"many_tasks 3 \(study: 2\), nearby_m 4\.0 \(study: 3"):
        policy.require_thresholds(Thresholds())


def test_wrong_sizes_are_refused_when_made_in_code() -> None:
    with pytest.raises(PolicyError, match="143 actions, wanted 144"):
        Policy("p", "initial", Thresholds(), (7,) * 143, (1,) * 18)


def test_files_are_named_in_errors(tmp_path: Path) -> None:
    """A missing, a huge and a damaged file: the path is in the sentence."""
    missing, huge, damaged = tmp_path / "none.json", tmp_path / "huge.json", tmp_path / "bad.json"
    huge.write_bytes(b" " * 1_000_001)
    damaged.write_text("{}")
    for path, what in ((missing, "cannot be read"), (huge, "larger than"), (damaged, "schema")):
        with pytest.raises(PolicyError, match=rf"{path.name}.*{what}"):
            read_policy_file(path)
    good = tmp_path / "good.json"
    good.write_text(initial_policy().to_json())
    assert read_policy_file(good) == initial_policy()
