"""What staff read of participants and their trials: lists, and one participant's whole story."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from server.store import staff_lists
from server.store.dashboard import LedgerEntry, Wanted, search_participants
from server.store.engine import Database
from server.store.lives import StatusChange, list_changes
from server.store.participants import ParticipantRecord, find_by_code, read_participant
from server.store.staff_lists import Listing
from server.store.stories import (
    Note,
    count_events,
    list_answers,
    list_claims,
    list_notes,
    list_trials,
)
from server.store.studies import read_version
from server.store.trials import TrialRecord, UnknownTrial, read_trial
from study.config import Study

Row = dict[str, Any]


@dataclass(frozen=True)
class Story:
    """Everything that is known of one participant; `study` is the version that was joined.

    `events`: by trial, how many of each kind.
    """

    person: ParticipantRecord
    study: Study
    trials: list[Row]
    changes: list[StatusChange]
    answers: list[Row]
    events: dict[str, dict[str, int]]
    claims: list[LedgerEntry]
    notes: list[Note]


@dataclass(frozen=True)
class StoryDesk:
    """Reads only; each question is answered from one view of the data."""

    database: Database

    async def search(
        self, wanted: Wanted, *, offset: int, limit: int
    ) -> tuple[list[ParticipantRecord], int]:
        """One page of the participants wanted, and how many there are."""
        async with self.database.reading() as session:
            return await search_participants(session, wanted, offset=offset, limit=limit)

    async def tell(self, code: str) -> Story:
        """The whole story of a participant; raises `UnknownParticipant`."""
        async with self.database.reading() as session:
            person = await find_by_code(session, code)
            return Story(
                person=person,
                study=await read_version(session, person.study_version_id),
                trials=await list_trials(session, person.id),
                changes=await list_changes(session, person.id),
                answers=await list_answers(session, person.id),
                events=await count_events(session, person.id),
                claims=await list_claims(session, person.id),
                notes=await list_notes(session, person.id),
            )

    async def find_trial(self, trial_id: str) -> tuple[TrialRecord, str]:
        """A participant's trial and the participant's code; raises `UnknownTrial`."""
        async with self.database.reading() as session:
            record = await read_trial(session, trial_id)
            if record.participant_id is None:
                raise UnknownTrial(trial_id)
            return record, (await read_participant(session, record.participant_id)).code

    async def list_people(self, wanted: Listing) -> tuple[list[Row], int]:
        """One page of participants for programs, and how many there are."""
        async with self.database.reading() as session:
            return await staff_lists.list_people(session, wanted)

    async def list_trials(self, wanted: Listing) -> tuple[list[Row], int]:
        """One page of trials for programs, and how many there are."""
        async with self.database.reading() as session:
            return await staff_lists.list_trials(session, wanted)
