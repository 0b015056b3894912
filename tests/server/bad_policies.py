"""Policy files that no door may take: what is wrong with each, and what has to be said."""

from __future__ import annotations

import json
from typing import Any

from study.ar.thresholds import Thresholds
from study.learning.policy import Policy, initial_policy

Record = dict[str, Any]


def _damaged(**changes: Any) -> bytes:
    return json.dumps(json.loads(initial_policy().to_json()) | changes).encode()


def _without_a_state() -> bytes:
    record: Record = json.loads(initial_policy().to_json())
    del record["robot_table"]["far/picking/few/short/few/few"]
    return json.dumps(record).encode()


BAD_FILES: dict[str, tuple[bytes, str]] = {
    "another schema": (_damaged(schema="varil-study"), "this is 'varil-study' version 1"),
    "a newer schema": (_damaged(schema_version=2), "version 2, wanted"),
    "a missing state": (_without_a_state(), "“far/picking/few/short/few/few” is missing"),
    "a wrong hash": (_damaged(sha256="0" * 64), "sha256: the file says"),
    "NaN": (initial_policy().to_json().replace("5.0", "NaN", 1).encode(), "NaN is no number"),
    "no JSON": (b"robot_table = 7", "this is no JSON"),
    "other borders": (
        initial_policy(Thresholds(close_m=4.0, many_tasks=3)).to_json().encode(),
        "close_m 4.0 (study: 5.0), many_tasks 3 (study: 2)",
    ),
}


def make_policy(name: str, origin: Any = "simulated", action: int = 3) -> Policy:
    """A sound policy that always does the same, as if it had been learned."""
    training = {
        "data_sha256": "ab" * 32,
        "settings": {"iterations": 240, "habits": {"wish": "inform", "replaced": {}}},
        "seed": 1,
        "scores": {"hamming_rate_before": 0.0125},
        "libraries": {"numpy": "2.4"},
    }
    return Policy(
        name,
        origin,
        Thresholds(),
        (action,) * 144,
        (action & 1,) * 18,
        None if origin == "initial" else training,
    )
