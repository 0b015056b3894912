"""A version of a learning run as a policy file: where it comes from and how far it came."""

from __future__ import annotations

import functools
import importlib.metadata
from collections.abc import Mapping
from typing import Any

from study.learning.curve import RATES
from study.learning.discrepancies import Discrepancies
from study.learning.policy import Origin, Policy
from study.learning.policy_up import Version
from study.learning.settings import LearningSettings

SCORED_ITERATIONS = 40
LIBRARIES = ("numpy", "scikit-learn")


def describe_version(
    version: Version,
    settings: LearningSettings,
    own: Discrepancies,
    origin: Origin,
    prefix: str,
    people: Mapping[str, Any],
) -> Policy:
    """Return a version, from iteration 1 on, as a policy named `<prefix>-<iteration>`.

    own: the discrepancies of the run, of which the 40 iterations before the version are its
    scores. people: who took part and where, told beside the settings.
    """
    before = slice(max(0, version.iterations - SCORED_ITERATIONS), version.iterations)
    return Policy(
        name=f"{prefix}-{version.iterations:03}",
        origin=origin,
        thresholds=settings.thresholds,
        robot_table=version.tables[0],
        station_table=version.tables[1],
        training={
            "data_sha256": version.data_sha256,
            "settings": {**settings.to_json(), **people, "iteration": version.iterations},
            "seed": settings.seed,
            "scores": {f"{rate}_before": round(getattr(own, rate)(before), 6) for rate in RATES},
            "libraries": dict(library_versions()),
        },
    )


@functools.cache
def library_versions() -> Mapping[str, str]:
    """The versions of what trains, without loading it."""
    return {name: importlib.metadata.version(name) for name in LIBRARIES}
