"""Rows for the benchmark's trials, so that their journals are stored as a study's are."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime

from server.live.ports import TrialSetup
from server.store.engine import Database
from server.store.participants import NewParticipant, add_participant, find_participant
from server.store.studies import keep_version
from server.store.trials import TrialRecord, add_trial
from study.files.demo import paper_study
from study.protocol.flow import Progress


async def add_bench_trials(database: Database, setups: Sequence[TrialSetup]) -> None:
    """One participant and one open trial per setup."""
    now, study = datetime.now(UTC), paper_study()
    async with database.writing() as session:
        version = await keep_version(session, study, now)
        for setup in setups:
            token = f"bench-{setup.trial_id}"
            new = NewParticipant(
                token, version, study.study_id, "bot", True, Progress("trial-1"), {}
            )
            await add_participant(session, new, now)
            owner = await find_participant(session, token)
            record = TrialRecord(
                id=setup.trial_id,
                participant_id=owner.id,
                step="trial-1",
                attempt=1,
                kind=setup.kind,
                position=1,
                condition=setup.condition,
                label=setup.label,
                scale=setup.scale,
                seed=setup.seed,
                config_hash=study.config_hash,
                config={},
                policy_sha256=None,
            )
            await add_trial(session, record, now)
