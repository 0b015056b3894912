"""Where the live loop gets trials from and leaves them: transactions around `server.store`."""

from __future__ import annotations

import uuid
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from typing import Any, cast

from server import policy_files
from server.live.ports import Kind, OpenTrial, TrialBatch, TrialResult, TrialSetup
from server.store.engine import Database
from server.store.journals import add_batches, lock_open, read_journal
from server.store.learning import add_rows, read_run
from server.store.moves import move, welcome_back, welcome_players
from server.store.participants import (
    ParticipantRecord,
    find_participant,
    note_shown,
    read_participant,
)
from server.store.policies import find_policy, keep_policy, read_policies
from server.store.studies import read_version
from server.store.trials import (
    TrialRecord,
    UnknownTrial,
    add_trial,
    find_trial,
    read_trial,
    store_result,
)
from study.config import Study
from study.errors import NotAllowedLive, WrongStep
from study.learning.policy import Policy, read_policy
from study.protocol.displays import display_label
from study.protocol.flow import IdleTooLong, Submission, TrialEnded, is_trial, step_kind
from study.protocol.orders import practice_seed, trial_seed
from study.warehouse.halls import HallSpec

Clock = Callable[[], datetime]
PolicySource = Callable[[Study, str], Policy | None]


def utc_now() -> datetime:
    """The wall clock."""
    return datetime.now(UTC)


def shipped_policy(study: Study, condition: str) -> Policy | None:
    """The policy that a condition runs where none was activated: for `varil` the shipped one.

    Raises `PolicyError` if it was made for other thresholds than the study's.
    """
    if condition != "varil":
        return None
    policy = policy_files.shipped_policy()
    policy.require_thresholds(study.thresholds)
    return policy


@dataclass(frozen=True)
class StoredTrialDesk:
    """Implements `server.live.ports.TrialDesk` on the database.

    Trials of participants are opened here, those of learning runs by `server.desks.learning`; the
    journals of both are committed and finished here.
    """

    database: Database
    time_scale: float = 1.0
    policy_for: PolicySource = shipped_policy
    clock: Clock = utc_now

    async def open_trial(self, token: str) -> OpenTrial:
        """The participant's current trial; raises `UnknownToken`, `WrongStep`, `NotAllowedLive`."""
        now = self.clock()
        async with self.database.writing() as session:
            participant = await find_participant(session, token, lock=True)
            step = participant.progress.page
            if participant.progress.outcome is not None or not is_trial(step):
                raise WrongStep("live", step)
            if participant.mode == "live" and self.time_scale != 1.0:
                raise NotAllowedLive(f"a time scale of {self.time_scale:g}")
            await note_shown(session, participant.id, now)
            await welcome_back(session, [participant], now)
            attempt = participant.progress.practice_tries + 1 if step == "practice" else 1
            trial = await find_trial(session, participant.id, step, attempt)
            if trial is None:
                study = await read_version(session, participant.study_version_id)
                active = await find_policy(session, study)
                trial, policy = self._plan_trial(study, participant, attempt, active)
                if policy is not None:
                    await keep_policy(session, policy, "shipped", now)
                await add_trial(session, trial, now)
            journal, events = await read_journal(session, trial.id)
            policies = await read_policies(session, [trial.policy_sha256 or ""])
        document = policies.get(trial.policy_sha256 or "")
        return OpenTrial(read_setup(trial, participant.mode, document), journal, events)

    async def recall(self, trial_id: str) -> OpenTrial:
        """A participant's stored trial with its journal; raises `UnknownTrial`."""
        async with self.database.reading() as session:
            trial = await read_trial(session, trial_id)
            if trial.participant_id is None:
                raise UnknownTrial(trial_id)
            participant = await read_participant(session, trial.participant_id)
            journal, events = await read_journal(session, trial.id)
            policies = await read_policies(session, [trial.policy_sha256 or ""])
        document = policies.get(trial.policy_sha256 or "")
        return OpenTrial(read_setup(trial, participant.mode, document), journal, events)

    async def commit(self, batches: Sequence[TrialBatch]) -> Collection[str]:
        """Store what all rooms added, in one transaction; returns the trials that are over."""
        async with self.database.writing() as session:
            open_ids = await lock_open(session, [batch.trial_id for batch in batches])
            wanted = [batch for batch in batches if batch.trial_id in open_ids]
            await add_batches(session, wanted, self.clock())
            await welcome_players(session, open_ids, self.clock())
            for batch in wanted:
                if batch.learning is not None:
                    await add_rows(session, batch.learning, self.clock())
        return {batch.trial_id for batch in batches} - open_ids

    async def finish(self, trial_id: str, result: TrialResult) -> None:
        """Store the result and move the participant on, in one transaction; once only.

        A learning run has no steps: of its trials only the result is stored.
        """
        now = self.clock()
        async with self.database.writing() as session:
            try:
                owner = await read_trial(session, trial_id)
            except UnknownTrial:
                return  # its participant's data were erased meanwhile
            participant = None
            if owner.participant_id is not None:
                participant = await read_participant(session, owner.participant_id, lock=True)
            elif owner.learning_run_id is not None:
                await read_run(session, owner.learning_run_id, lock=True)
            trial = await read_trial(session, trial_id, lock=True)
            if trial.status != "open":
                return
            await store_result(session, trial_id, result)
            if participant is None:
                return
            progress = participant.progress
            if progress.outcome is None and progress.step == trial.step:
                study = await read_version(session, participant.study_version_id)
                submission: Submission = IdleTooLong()
                if result.status != "abandoned":
                    submission = TrialEnded(trial.step, result.status)
                await move(session, study, participant, submission, now)

    def _plan_trial(
        self, study: Study, participant: ParticipantRecord, attempt: int, active: str | None
    ) -> tuple[TrialRecord, Policy | None]:
        """Everything that determines the trial besides the participant's inputs."""
        step = participant.progress.page
        kind, position = step_kind(step)
        if position is None:
            condition, scale = study.practice.condition, study.practice.scale
            seed, label = practice_seed(study.seed, attempt), "Practice"
        else:
            slot = participant.slot
            if slot is None:
                raise RuntimeError(f"participant {participant.code} is at {step} without an order")
            condition = cast("Any", study.orders[slot.order_index][position - 1])
            seed, scale = trial_seed(study.seed, slot.block, position), study.scale_at(position)
            label = display_label(position)
        policy = self._choose_policy(study, condition, active)
        trial = TrialRecord(
            id=uuid.uuid4().hex,
            participant_id=participant.id,
            step=step,
            attempt=attempt,
            kind=kind,
            position=position,
            condition=condition,
            label=label,
            scale=scale,
            seed=seed,
            config_hash=study.config_hash,
            config={
                "hall": _limit(study.hall_spec(scale), study, kind).to_json(),
                "seed": seed,
                "condition": condition,
                "policy_sha256": policy.sha256 if policy else None,
                "thresholds": study.thresholds.to_json(),
                "ribbon_widest_at": study.display.ribbon_widest_at,
                "time_scale": min(self.time_scale, study.limits.time_scale),
                "on_disconnect": study.limits.on_disconnect,
                "abandon_after_s": study.limits.abandon_after_s,
            },
            policy_sha256=policy.sha256 if policy else None,
        )
        return trial, policy

    def _choose_policy(self, study: Study, condition: str, active: str | None) -> Policy | None:
        """The policy activated for the study, else the source's own; PolicyError if it is for
        other thresholds than the study's.
        """
        if condition != "varil" or active is None:
            return self.policy_for(study, condition)
        policy = read_policy(active)
        policy.require_thresholds(study.thresholds)
        return policy


def _limit(hall: HallSpec, study: Study, kind: str) -> HallSpec:
    """The hall with the study's own limit on a trial's length, where it has one."""
    limit_s = study.limits.trial_s
    return hall if limit_s is None or kind != "trial" else replace(hall, cap_s=limit_s)


def read_setup(trial: TrialRecord, mode: str, policy_document: str | None) -> TrialSetup:
    """What the live loop needs, read from what was stored when the trial was opened."""
    policy = None if policy_document is None else read_policy(policy_document)
    config = trial.config
    return TrialSetup(
        trial_id=trial.id,
        kind=cast("Kind", trial.kind),
        scale=trial.scale,
        spec=HallSpec.from_json(config["hall"]),
        seed=trial.seed,
        condition=trial.condition,
        policy=policy,
        label=trial.label,
        mode=mode,
        time_scale=config["time_scale"],
        on_disconnect=config["on_disconnect"],
        abandon_after_s=config["abandon_after_s"],
        ribbon_widest_at=config["ribbon_widest_at"],
        number=config["learning"]["number"] if "learning" in config else None,
    )
