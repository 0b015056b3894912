"""Where the rows of each table of the export come from, a page at a time."""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterable, Mapping
from dataclasses import dataclass
from itertools import groupby
from operator import itemgetter
from typing import Any

from server.export.items import complete_answer, complete_person, score_answers
from server.store.export_rows import (
    TRIALS_PER_PAGE,
    Pages,
    Part,
    Row,
    Selection,
    answers_of,
    label_pages,
    notes_of,
    panel_ids_of,
    parts_of,
    people_pages,
    trials_of,
)
from study.config import Study
from study.protocol.exclusions import flag_participant, flag_trial
from study.records.cells import Table
from study.records.wide import wide_row
from study.warehouse.halls import TICK_HZ

DOMAINS = ("robot", "station")


@dataclass(frozen=True)
class Sources:
    """The rows of one study in one transaction. `versions`: the study by hash."""

    session: Any
    chosen: Selection
    versions: Mapping[str, Study]

    async def people(self) -> Pages:
        """Rows of participants.csv."""
        async for page in people_pages(self.session, self.chosen):
            figures: dict[str, list[Row]] = {}
            for row in await self._judged(page):
                figures.setdefault(row["participant_code"], []).append(row)
            for row in page:
                study = self.versions[row["config_hash"]]
                complete_person(row, study)
                trials = figures.get(row["participant_code"], [])
                row["flags"] = "|".join(flag_participant(study.exclusion, trials)) or None
            yield page

    async def trials(self) -> Pages:
        """Rows of trials.csv."""
        async for page in people_pages(self.session, self.chosen):
            yield await trials_of(self.session, page)

    async def parts(self, part: Part) -> Pages:
        """Rows of robots.csv, legs.csv or events.csv."""
        async for trials in self.trials():
            for first in range(0, len(trials), TRIALS_PER_PAGE):
                some = trials[first : first + TRIALS_PER_PAGE]
                rows = await parts_of(self.session, some, part)
                if part == "events":
                    for row in rows:
                        row["time_s"] = round(row["tick"] / TICK_HZ, 3)
                yield rows

    async def quality(self) -> Pages:
        """Rows of quality.csv."""
        async for page in people_pages(self.session, self.chosen):
            yield [row for row in await self._judged(page) if "pauses" in row]

    async def answers(self) -> Pages:
        """Rows of responses.csv."""
        async for page in people_pages(self.session, self.chosen):
            yield await self._answers(page)

    async def wide(self, table: Table) -> Pages:
        """Rows of wide.csv; those who withdrew have none, as in all tables but participants."""
        async for page in self.people():
            trials = _by_person(await trials_of(self.session, page))
            answers = _by_person(await self._answers(page))
            rows = []
            for person in page:
                code = person["participant_code"]
                if person["status"] != "withdrawn":
                    given = answers.get(code, [])
                    scores = score_answers(self.versions[person["config_hash"]], given)
                    rows.append(wide_row(table, person, trials.get(code, ()), given + scores))
            yield rows

    async def panel_ids(self) -> Pages:
        """Rows of panel_ids.csv."""
        async for page in people_pages(self.session, self.chosen):
            yield await panel_ids_of(self.session, page)

    async def labels(self, policies: Iterable[str]) -> Pages:
        """Rows of expert_labels.csv: of the runs that these policies come from."""
        async for page in label_pages(self.session, list(policies)):
            for row in page:
                row |= {"study_id": self.chosen.study_id, "config_hash": None, "mode": None}
                row["domain"] = DOMAINS[row["domain"]]
                row["by_expert"] = bool(row["by_expert"])
            yield page

    async def notes(self) -> Pages:
        """Rows of notes.csv."""
        async for page in people_pages(self.session, self.chosen):
            rows = await notes_of(self.session, page)
            for _, mine in groupby(rows, itemgetter("participant_code")):
                for number, row in enumerate(mine):
                    tick = row["tick"]
                    row["number"] = number
                    row["time_s"] = None if tick is None else round(tick / TICK_HZ, 3)
            yield rows

    async def ended_trials(self) -> AsyncIterator[Row]:
        """Rows of trials.csv that have a world to re-simulate, one by one."""
        async for page in self.trials():
            for row in page:
                if row["ticks"]:
                    yield row

    async def _answers(self, page: list[Row]) -> list[Row]:
        rows = await answers_of(self.session, page)
        for row in rows:
            complete_answer(row, self.versions[row["config_hash"]])
        return rows

    async def _judged(self, page: list[Row]) -> list[Row]:
        """Ended trials with their quality, as far as it was measured, and the flags they earn."""
        trials = await trials_of(self.session, page)
        measured = {row["trial_id"]: row for row in await parts_of(self.session, trials, "quality")}
        judged = []
        for trial in trials:
            if trial["status"] == "open":
                continue
            row = trial | measured.get(trial["trial_id"], {})
            rules = self.versions[row["config_hash"]].exclusion
            row["flags"] = "|".join(flag_trial(rules, row)) or None
            judged.append(row)
        return judged


def _by_person(rows: Iterable[Row]) -> dict[str, list[Row]]:
    found: dict[str, list[Row]] = {}
    for row in rows:
        found.setdefault(row["participant_code"], []).append(row)
    return found
