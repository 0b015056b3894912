"""Guards which policy a trial runs, and what the list of policies counts and leaves out."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime

import pytest

from server.desks.policies import ConfirmationNeeded, PolicyDesk
from server.desks.trials import StoredTrialDesk
from server.export.bundle import ExportOptions, stream_export
from server.live.learning.rows import RunVersion
from server.live.ports import TrialResult
from server.policy_files import shipped_policy
from server.store.audit import AuditWanted, search_audit
from server.store.engine import Database
from server.store.policies import PolicyEntry
from study.ar.thresholds import Thresholds
from study.config import Study
from study.errors import InvalidValue, PolicyError
from study.learning.policy import Policy
from tests.server.bad_policies import make_policy
from tests.server.desks.test_trials import Site
from tests.server.learning_lab import Lab, batch, rows

MakeResult = Callable[..., TrialResult]
TAUGHT, BRED = make_policy("taught", "people", 1), make_policy("bred", "simulated", 2)


@pytest.fixture
def adaptive(study: Study) -> Study:
    """The demo study with the adaptive display alone."""
    return study.revised(conditions=("varil",))


@pytest.fixture
def site(database: Database, adaptive: Study, make_result: MakeResult) -> Site:
    return Site(database, adaptive, make_result)


@pytest.fixture
async def desk(database: Database, adaptive: Study) -> PolicyDesk:
    opened = PolicyDesk(database, {"demo": adaptive})
    for policy in (TAUGHT, BRED):
        await opened.upload(policy.to_json().encode(), "ann")
    return opened


async def give(desk: PolicyDesk, policy: Policy, *, confirmed: bool = False) -> None:
    await desk.activate(policy.sha256, "demo", "ann", confirmed=confirmed)


async def policy_met(site: Site) -> Policy | None:
    """What somebody new would meet in the first trial."""
    token = await site.walk_to("trial-1")
    return (await site.desk.open_trial(token)).setup.policy


async def test_trials_run_the_newest_activation_and_before_it_the_shipped_one(
    site: Site, desk: PolicyDesk
) -> None:
    assert await policy_met(site) == shipped_policy()
    for policy in (TAUGHT, BRED, TAUGHT):
        await give(desk, policy)
        assert await policy_met(site) == policy


async def test_a_trial_keeps_the_policy_it_was_opened_with(site: Site, desk: PolicyDesk) -> None:
    token = await site.walk_to("trial-1")
    await give(desk, TAUGHT)
    before = (await site.desk.open_trial(token)).setup
    await give(desk, BRED)
    again = await StoredTrialDesk(site.database).open_trial(token)
    assert (before.policy, again.setup.policy) == (TAUGHT, TAUGHT)


async def test_other_studies_and_conditions_are_not_touched(
    database: Database, desk: PolicyDesk, study: Study, make_result: MakeResult
) -> None:
    await give(desk, TAUGHT)
    other = Site(database, study.revised(study_id="other", conditions=("varil",)), make_result)
    assert await policy_met(other) == shipped_policy()
    plain = Site(database, study.revised(study_id="plain", conditions=("arroch",)), make_result)
    assert await policy_met(plain) is None
    with pytest.raises(InvalidValue, match="no condition"):
        await PolicyDesk(database, {"plain": plain.study}).activate(
            TAUGHT.sha256, "plain", "ann", confirmed=True
        )


async def test_a_policy_that_no_longer_fits_is_not_run(
    database: Database, desk: PolicyDesk, adaptive: Study, make_result: MakeResult
) -> None:
    """A new version of the study moved a border after the policy was activated."""
    await give(desk, TAUGHT)
    moved = Site(database, adaptive.revised(thresholds={"far_m": 16.0}), make_result)
    with pytest.raises(PolicyError, match=r"far_m 15\.0 \(study: 16\.0\)"):
        await policy_met(moved)


async def test_live_studies_get_simulated_policies_only_when_confirmed(
    database: Database, desk: PolicyDesk, adaptive: Study
) -> None:
    live = PolicyDesk(database, {"demo": adaptive.revised(recruiting="live")})
    await give(live, TAUGHT)
    with pytest.raises(ConfirmationNeeded, match="“demo” recruits live participants"):
        await give(live, BRED)
    active = await live.find_active(live.studies["demo"])
    assert active is not None
    assert active.policy == TAUGHT
    for _ in range(2):
        await give(live, BRED, confirmed=True)
    async with database.reading() as session:
        found, _ = await search_audit(session, AuditWanted(), offset=0, limit=9)
    noted = [detail for _, _, what, detail in found if "activ" in what]
    assert noted == [f"demo: {p.name} ({p.origin}), {p.sha256}" for p in (BRED, TAUGHT)]


async def entries(desk: PolicyDesk, run_id: str = "") -> dict[str, PolicyEntry]:
    found, total = await desk.list_policies(run_id, offset=0, limit=100)
    assert len(found) == total
    return {entry.name: entry for entry in found}


async def test_of_a_run_the_newest_version_and_those_in_use_are_listed(
    database: Database, desk: PolicyDesk
) -> None:
    lab = await Lab(database).start()
    setup = await lab.begin(0)
    learned = [replace(make_policy("x", "people"), name=f"v{n}") for n in range(4)]
    versions = tuple(RunVersion(n, policy) for n, policy in enumerate(learned))
    sent = rows(lab.run_id, 0, 130, versions=versions)
    assert sent.iteration == 5, "two more are closed, and still in training"
    await lab.trials.commit([batch(setup.trial_id, 1, sent)])
    assert set(await entries(desk)) == {"taught", "bred", "v3"}
    await give(desk, learned[1])
    listed = await entries(desk)
    assert set(listed) == {"taught", "bred", "v3", "v1"}
    assert (listed["v1"].run_id, listed["v1"].iteration) == (lab.run_id, 1)
    assert (listed["v1"].studies, listed["v3"].studies) == (("demo",), ())
    assert list(await entries(desk, lab.run_id)) == ["v3", "v2", "v1", "v0"]


async def test_trials_are_counted_with_the_policy_they_ran(site: Site, desk: PolicyDesk) -> None:
    for policy, people in ((TAUGHT, 2), (BRED, 1)):
        await give(desk, policy)
        for _ in range(people):
            await policy_met(site)
    listed = await entries(desk)
    assert {name: entry.trials for name, entry in listed.items()} == {"taught": 2, "bred": 1}
    assert {name: entry.source for name, entry in listed.items()} == dict.fromkeys(
        listed, "uploaded"
    )


async def test_the_export_says_where_each_policy_comes_from(site: Site, desk: PolicyDesk) -> None:
    """In README.txt and in the codebook, for those alone that trials ran."""
    await give(desk, BRED)
    await policy_met(site)
    pieces = [piece async for piece in stream_export(site.database, ExportOptions("demo", "pilot"))]
    with zipfile.ZipFile(io.BytesIO(b"".join(pieces))) as bundle:
        readme, codebook = (bundle.read(n).decode() for n in ("README.txt", "codebook.csv"))
    assert f"- {BRED.sha256}: “bred”, learned from simulated people" in readme
    assert f"{BRED.sha256}=bred (learned from simulated people)" in codebook
    assert TAUGHT.sha256 not in readme + codebook


async def test_the_same_file_twice_is_one_policy(desk: PolicyDesk) -> None:
    await desk.upload(TAUGHT.to_json().encode(), "ben")
    assert set(await entries(desk)) == {"taught", "bred"}


async def test_a_policy_that_fits_any_study_here_may_be_uploaded(
    database: Database, adaptive: Study
) -> None:
    moved = adaptive.revised(study_id="moved", thresholds={"close_m": 4.0})
    desk = PolicyDesk(database, {"demo": adaptive, "moved": moved})
    fitting = replace(TAUGHT, thresholds=Thresholds(close_m=4.0))
    await desk.upload(fitting.to_json().encode(), "ann")
    entry = await desk.read_entry(fitting.sha256)
    assert entry.added_at <= datetime.now(UTC)
