"""Guards live learning runs: what was stored comes back as it was, once, and all of it or nothing.

Each test runs on SQLite and on a real PostgreSQL server.
"""

from __future__ import annotations

import asyncio
import csv
import io
from collections.abc import Callable
from pathlib import Path

import pytest
from sqlalchemy import select

from server.desks.learning import NoWorkerLink, RunOver
from server.desks.participants import ParticipantDesk
from server.export.bundle import ExportOptions, stream_export
from server.headless.learning import write_dataset
from server.live.learning.rows import RunVersion
from server.live.ports import TrialResult
from server.store.engine import Database
from server.store.tables import LearningPair, LearningRun, Trial, TrialRobot
from study.config import Study
from study.errors import UnknownRun, UnknownToken
from study.learning.dataset import Dataset
from study.learning.policy import initial_policy
from study.warehouse.halls import PRESETS
from tests.server.bad_policies import make_policy
from tests.server.learning_lab import SETTINGS, START, Lab, batch, pair, rating, rows

MakeResult = Callable[..., TrialResult]


@pytest.fixture
async def lab(database: Database) -> Lab:
    return await Lab(database).start()


async def test_a_new_run_comes_back_as_it_was_asked_for(lab: Lab) -> None:
    run = await lab.read()
    assert (run.setup.run_id, run.setup.settings) == (lab.run_id, SETTINGS)
    assert (run.setup.scale, run.setup.spec) == ("small", PRESETS["small"])
    assert (run.setup.worker, run.setup.created_by, run.status) == ("person", "ann", "open")
    assert (run.versions, run.pairs, run.ratings, run.trials) == ((), (), (), 0)
    assert (run.trial, run.start) == (None, None)


async def test_the_present_trial_comes_back_with_its_start_and_journal(lab: Lab) -> None:
    """What a restarted server needs: setup, start, inputs and experts' events of the trial."""
    setup = await lab.begin(0)
    await lab.begin(0)
    sent = [batch(setup.trial_id, 1, rows(lab.run_id, 0, 5)), batch(setup.trial_id, 3, None)]
    assert set(await lab.trials.commit(sent)) == set()
    run = await lab.read()
    assert run.trial is not None
    assert run.trial.setup == setup
    assert (run.start, run.trials) == (START, 1)
    assert run.trial.journal == tuple(b.chunk for b in sent)
    assert run.trial.events == tuple(event for b in sent for event in b.events)
    assert run.pairs == tuple(pair(number) for number in range(5))


async def test_rows_that_come_twice_are_stored_once(lab: Lab) -> None:
    """A batch is offered again when the answer to it was lost; later ones may ride along."""
    setup = await lab.begin(0)
    versions = tuple(RunVersion(n, make_policy(f"v{n}", "people", n)) for n in (1, 2))
    ratings = ((0, rating(0)), (1, rating(1)))
    first = batch(setup.trial_id, 1, rows(lab.run_id, 0, 50, versions=versions, ratings=ratings))
    later = batch(setup.trial_id, 3, rows(lab.run_id, 50, 60, ratings=((2, rating(2)),)))
    initial = RunVersion(0, initial_policy())
    opening = batch(setup.trial_id, 1, rows(lab.run_id, 0, 0, versions=(initial,)))
    await lab.trials.commit([opening])
    await lab.trials.commit([first])
    await lab.trials.commit([first, later])
    await lab.trials.commit([first])
    run, summary = await lab.read(), await lab.desk.read_run_summary(lab.run_id)
    assert run.pairs == tuple(pair(number) for number in range(60))
    assert run.versions == (initial, *versions)
    assert run.ratings == (rating(0), rating(1), rating(2))
    assert (summary.iteration, summary.pairs, summary.status) == (2, 60, "open")


async def test_a_batch_is_stored_whole_or_not_at_all(lab: Lab) -> None:
    """The journal must never be ahead of the dataset, or a replay would add pairs twice."""
    setup = await lab.begin(0)
    with pytest.raises(UnknownRun):
        await lab.trials.commit([batch(setup.trial_id, 1, rows("f" * 32, 0, 5))])
    run = await lab.read()
    assert run.trial is not None
    assert (run.trial.journal, run.pairs) == ((), ())


async def test_the_next_trial_follows_a_finished_one(lab: Lab, make_result: MakeResult) -> None:
    first = await lab.begin(0)
    for _ in range(2):
        await lab.trials.finish(first.trial_id, make_result())
    ended = await lab.read()
    assert (ended.trial_ended, ended.start) == (True, START), "the next begins from where it ended"
    second = await lab.begin(1)
    run = await lab.read()
    assert run.trial is not None
    assert (run.trial.setup, run.trials, run.trial_ended) == (second, 2, False)
    assert await lab.count(TrialRobot) == 2, "measured once"
    with pytest.raises(RuntimeError, match="trial 5 after 2"):
        await lab.begin(5)


async def test_a_trial_given_up_is_left_for_the_next(lab: Lab) -> None:
    first = await lab.begin(0)
    await lab.begin(1)
    over = await lab.trials.commit([batch(first.trial_id, 1, rows(lab.run_id, 0, 5))])
    assert set(over) == {first.trial_id}
    assert (await lab.read()).pairs == ()


async def test_a_run_that_finished_stays_finished(lab: Lab) -> None:
    setup = await lab.begin(0)
    done = rows(lab.run_id, 0, 75, finished=True)
    await lab.trials.commit([batch(setup.trial_id, 1, done)])
    await lab.desk.stop_run(lab.run_id, "ann")
    await lab.desk.end_run(lab.run_id, "stopped")
    summary = await lab.desk.read_run_summary(lab.run_id)
    assert (summary.status, summary.iteration, summary.pairs) == ("finished", 3, 75)
    assert summary.ended_at is not None
    with pytest.raises(RunOver):
        await lab.begin(1)


@pytest.mark.parametrize("by_staff", [True, False])
async def test_a_stopped_run_takes_nothing_more(lab: Lab, by_staff: bool) -> None:
    """Its room learns so from its next commit; what was stored before stays."""
    setup = await lab.begin(0)
    await lab.trials.commit([batch(setup.trial_id, 1, rows(lab.run_id, 0, 5))])
    if by_staff:
        await lab.desk.stop_run(lab.run_id, "ann")
    else:
        await lab.desk.end_run(lab.run_id, "stopped")
    over = await lab.trials.commit([batch(setup.trial_id, 3, rows(lab.run_id, 5, 9))])
    assert set(over) == {setup.trial_id}
    run = await lab.read()
    assert (run.status, len(run.pairs), run.trial_ended) == ("stopped", 5, True)


async def test_a_worker_is_found_by_the_newest_link_only(lab: Lab) -> None:
    assert lab.token is not None
    assert await lab.desk.find_worker(lab.token) == lab.run_id
    newer = await lab.desk.renew_worker_link(lab.run_id, "ann")
    assert await lab.desk.find_worker(newer) == lab.run_id
    for token in (lab.token, "x" * 32, "", "\x00"):
        with pytest.raises(UnknownToken):
            await lab.desk.find_worker(token)
    async with lab.database.reading() as session:
        row = (await session.scalars(select(LearningRun))).one()
    assert newer not in repr([getattr(row, c.key) for c in LearningRun.__table__.columns])


async def test_links_are_made_for_people_in_open_runs_only(database: Database) -> None:
    simulated, ended = await Lab(database).start("simulated"), await Lab(database).start()
    assert simulated.token is None
    with pytest.raises(NoWorkerLink):
        await simulated.desk.renew_worker_link(simulated.run_id, "ann")
    await ended.desk.stop_run(ended.run_id, "ann")
    with pytest.raises(RunOver):
        await ended.desk.renew_worker_link(ended.run_id, "ann")


@pytest.mark.parametrize("run_id", ["0" * 32, "", "\x00", "../x"])
async def test_an_unknown_run_is_told_as_such(lab: Lab, run_id: str) -> None:
    for ask in (lab.desk.open_run, lab.desk.read_run_summary):
        with pytest.raises(UnknownRun):
            await ask(run_id)


async def test_the_dataset_has_the_columns_and_cells_of_varil_learn(
    lab: Lab, tmp_path: Path
) -> None:
    """Read by the same scripts; only the origin tells people from simulated people."""
    setup = await lab.begin(0)
    await lab.trials.commit([batch(setup.trial_id, 1, rows(lab.run_id, 0, 1203))])
    text = "".join([piece async for piece in lab.desk.stream_dataset(lab.run_id)])
    dataset = Dataset()
    for number in range(1203):
        dataset.add(pair(number))
    write_dataset(tmp_path / "dataset.csv", dataset, SETTINGS)
    with (tmp_path / "dataset.csv").open(newline="") as file:
        theirs = list(csv.DictReader(file))
    ours = list(csv.DictReader(io.StringIO(text, newline="")))
    assert ours == [row | {"origin": "people"} for row in theirs]
    assert (list(ours[0]), len(ours)) == (list(theirs[0]), 1203)


async def test_many_runs_at_once_do_not_get_into_each_others_way(database: Database) -> None:
    labs = [await Lab(database).start() for _ in range(4)]
    setups = [await lab.begin(0, f"{n:032x}") for n, lab in enumerate(labs)]
    commits = [
        lab.trials.commit([batch(setup.trial_id, 1, rows(lab.run_id, 0, 30))])
        for lab, setup in zip(labs, setups, strict=True)
    ]
    stops = [lab.desk.stop_run(lab.run_id, "ann") for lab in labs[:2]]
    await asyncio.gather(*commits, *stops)
    assert await labs[3].count(LearningPair) in (60, 90, 120)
    assert [len((await lab.read()).pairs) for lab in labs[2:]] == [30, 30]


async def test_the_export_of_a_study_knows_nothing_of_runs(
    lab: Lab, study: Study, make_result: MakeResult
) -> None:
    """Nor do participants' pages: a run's trial belongs to nobody who takes part."""
    setup = await lab.begin(0)
    await lab.trials.finish(setup.trial_id, make_result())
    people = ParticipantDesk(lab.database, {"demo": study}, b"k" * 32)
    await people.register_studies()
    await people.join("demo", "", {})
    counts: dict[str, int] = {}
    pieces = [piece async for piece in stream_export(lab.database, ExportOptions("demo"), counts)]
    assert pieces
    assert (counts["trials"], counts["robots"], counts["legs"]) == (0, 0, 0)
    assert await lab.count(Trial) == 1
