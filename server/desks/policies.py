"""What pages and start-up ask about policies: which there are, and which each study runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from server.desks.trials import Clock, utc_now
from server.policy_files import read_policy_upload, shipped_policy
from server.store import policies as stored
from server.store.audit import add_audit
from server.store.engine import Database
from server.store.learning import read_run
from server.store.policies import PolicyEntry
from study.config import Study
from study.errors import InvalidValue, PolicyError, UnknownStudy, WrongMoment
from study.learning.policy import Policy, read_policy

ADAPTIVE = "varil"


class ConfirmationNeeded(WrongMoment):
    """A policy learned from simulated people was to be given to a study that recruits live."""

    def __init__(self, policy: Policy, study: Study) -> None:
        super().__init__(
            f"the study “{study.study_id}” recruits live participants, and the policy "
            f"“{policy.name}” was learned from simulated people",
            next_step="Tick the box if that is meant, and activate it again.",
        )


@dataclass(frozen=True)
class ActivePolicy:
    """The policy that a study runs; `chosen` is False where the shipped one stands in."""

    policy: Policy
    chosen: bool


@dataclass(frozen=True)
class PolicyDesk:
    """Owns the transactions about policies."""

    database: Database
    studies: Mapping[str, Study]
    clock: Clock = utc_now

    @property
    def adaptive_studies(self) -> tuple[Study, ...]:
        """Studies with a condition that runs a policy."""
        return tuple(s for s in self.studies.values() if ADAPTIVE in s.conditions)

    async def register_shipped(self) -> None:
        """Store the policy that comes with the software, so that it can be seen and chosen."""
        async with self.database.writing() as session:
            await stored.keep_policy(session, shipped_policy(), "shipped", self.clock())

    async def list_policies(
        self, run_id: str = "", *, offset: int, limit: int
    ) -> tuple[list[PolicyEntry], int]:
        """One page of policies, or of one learning run's versions, and how many there are.

        Raises UnknownRun.
        """
        async with self.database.reading() as session:
            if run_id:
                await read_run(session, run_id)
                return await stored.list_run_policies(session, run_id, offset=offset, limit=limit)
            return await stored.list_policies(session, offset=offset, limit=limit)

    async def read_entry(self, sha256: str) -> PolicyEntry:
        """A stored policy with its use; raises `UnknownPolicy`."""
        async with self.database.reading() as session:
            return await stored.read_entry(session, sha256)

    async def upload(self, data: bytes, user_name: str) -> Policy:
        """Store a policy file. Raises PolicyError naming what is wrong, and stores nothing then.

        A policy for other state borders than any study here has could be given to none.
        """
        policy = read_policy_upload(data)
        _require_any(policy, tuple(self.studies.values()))
        now = self.clock()
        async with self.database.writing() as session:
            if await stored.keep_policy(session, policy, "uploaded", now):
                detail = f"{policy.name[:120]}, {policy.sha256}"
                await add_audit(session, user_name, "policy uploaded", detail, now)
        return policy

    async def activate(
        self, sha256: str, study_id: str, user_name: str, *, confirmed: bool
    ) -> None:
        """Let a study run this policy from now on; trials that were opened keep theirs.

        Raises `UnknownPolicy`, UnknownStudy, PolicyError for other thresholds, InvalidValue if
        the study runs no policy, `ConfirmationNeeded` unless confirmed.
        """
        if study_id not in self.studies:
            raise UnknownStudy(study_id)
        study = self.studies[study_id]
        if ADAPTIVE not in study.conditions:
            raise InvalidValue(
                f"no condition of the study “{study_id}” runs a policy",
                next_step=f"Choose a study with the condition {ADAPTIVE}.",
            )
        if study.policy_sha256:
            raise InvalidValue(
                f"the file of the study “{study_id}” names its policy",
                next_step="Name another one there, or take the key `policy` out of it.",
            )
        now = self.clock()
        async with self.database.writing() as session:
            policy = read_policy((await stored.read_entry(session, sha256)).document)
            policy.require_thresholds(study.thresholds)
            if needs_confirmation(policy, study) and not confirmed:
                raise ConfirmationNeeded(policy, study)
            active = await stored.find_active(session, study_id)
            if active is not None and read_policy(active).sha256 == sha256:
                return
            await stored.activate(session, study_id, sha256, user_name, now)
            detail = f"{study_id}: {policy.name[:60]} ({policy.origin}), {sha256}"
            await add_audit(session, user_name, "policy activated", detail, now)

    async def find_active(self, study: Study) -> ActivePolicy | None:
        """The policy that a study's trials run; None if no condition of it runs one."""
        if ADAPTIVE not in study.conditions:
            return None
        async with self.database.reading() as session:
            document = await stored.find_policy(session, study)
        if document is None:
            return ActivePolicy(shipped_policy(), chosen=False)
        return ActivePolicy(read_policy(document), chosen=True)

    async def list_warnings(self) -> list[str]:
        """What whoever starts the server should know about its studies' policies."""
        found = []
        for study in self.studies.values():
            active = await self.find_active(study)
            if active is None:
                continue
            if needs_confirmation(active.policy, study):
                found.append(
                    f"the study “{study.study_id}” recruits live participants, and its policy "
                    f"“{active.policy.name}” was learned from simulated people. Another one can "
                    "be activated at /admin/policies."
                )
            try:
                active.policy.require_thresholds(study.thresholds)
            except PolicyError as problem:
                found.append(
                    f"trials of the study “{study.study_id}” that run a policy cannot be opened: "
                    f"{problem.what}. Activate a fitting one at /admin/policies."
                )
        return found


def needs_confirmation(policy: Policy, study: Study) -> bool:
    """Whether giving this policy to this study has to be confirmed."""
    return policy.origin == "simulated" and study.recruiting == "live"


def _require_any(policy: Policy, studies: Sequence[Study]) -> None:
    problems = []
    for study in studies:
        try:
            policy.require_thresholds(study.thresholds)
        except PolicyError as problem:
            problems.append(problem)
        else:
            return
    if problems:
        raise problems[0]
