"""Learning runs between their rows in the database and the records of the live loop."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any

from server.live.learning.ports import RunSetup
from server.live.learning.rows import RunVersion
from server.live.ports import TrialSetup
from server.store.learning import RunRecord
from server.store.trials import TrialRecord
from study.learning.policy import read_policy
from study.learning.settings import LearningSettings
from study.warehouse.halls import HallSpec

STEP = "learning"


def read_settings(run: RunRecord) -> LearningSettings:
    """The run's settings with their thresholds."""
    record = dict(run.settings)
    thresholds = record.pop("thresholds")
    return LearningSettings.from_json(record, thresholds)


def run_setup(run: RunRecord) -> RunSetup:
    """What determines the run besides its people."""
    return RunSetup(
        run_id=run.id,
        settings=read_settings(run),
        scale=run.scale,
        spec=HallSpec.from_json(run.hall),
        worker=run.worker,
        created_by=run.created_by,
    )


def read_versions(documents: list[tuple[int, str]]) -> tuple[RunVersion, ...]:
    """Hundreds of files take a moment, so this runs beside the trials' ticks."""
    return tuple(RunVersion(iteration, read_policy(text)) for iteration, text in documents)


def record_trial(
    run: RunRecord, number: int, setup: TrialSetup, start: Mapping[str, Any]
) -> TrialRecord:
    """The row of a run's trial; with its journal it gives every state of world and run again."""
    fixed = json.dumps({"hall": run.hall, "settings": run.settings}, sort_keys=True)
    return TrialRecord(
        id=setup.trial_id,
        participant_id=None,
        learning_run_id=run.id,
        step=STEP,
        attempt=number + 1,
        kind="learning",
        position=None,
        condition=setup.condition,
        label=setup.label,
        scale=setup.scale,
        seed=setup.seed,
        config_hash=hashlib.sha256(fixed.encode()).hexdigest(),
        config={
            "hall": setup.spec.to_json(),
            "seed": setup.seed,
            "condition": setup.condition,
            "mode": setup.mode,
            "policy_sha256": None,
            "thresholds": run.settings["thresholds"],
            "ribbon_widest_at": setup.ribbon_widest_at,
            "time_scale": setup.time_scale,
            "on_disconnect": setup.on_disconnect,
            "abandon_after_s": setup.abandon_after_s,
            STEP: {"run_id": run.id, "number": number, "start": dict(start)},
        },
        policy_sha256=None,
    )
