"""What participants' pages ask of the server: join, see the current step, send a form, withdraw.

Each method is one transaction. The server owns progress: a step is left only when what belongs to
it is committed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import cast

from server.desks.trials import Clock, utc_now
from server.store.engine import Database
from server.store.moves import end_idle, move, pause_absent, welcome_back
from server.store.panel_ids import read_panel_ids, renew_token
from server.store.participants import (
    NewParticipant,
    ParticipantRecord,
    add_participant,
    find_participant,
    note_shown,
)
from server.store.responses import add_answers, read_answers
from server.store.studies import keep_version, read_version
from server.tokens import derive_panel_token, derive_token, looks_like_token
from study.config import Study
from study.errors import AnswerError, UnknownStudy, UnknownToken, WrongStep
from study.protocol.answers import validate_answers
from study.protocol.device import judge_device
from study.protocol.flow import FormSent, Withdrawal, comes_before, start, step_kind
from study.protocol.lifecycle import Outcome
from study.protocol.panel import TookPartAlready
from study.protocol.questionnaires import Instrument


@dataclass(frozen=True)
class Visit:
    """A participant at the door, with the study as it was when they joined."""

    participant: ParticipantRecord
    study: Study

    def instruments(self, step_kind: str) -> tuple[Instrument, ...]:
        """What a kind of step asks this participant, in their order of items."""
        seed, code = self.study.seed, self.participant.code
        return tuple(one.arranged(seed, code) for one in self.study.instruments(step_kind))


@dataclass(frozen=True)
class ParticipantDesk:
    """Owns the transactions of participants' pages."""

    database: Database
    studies: Mapping[str, Study]
    secret_key: bytes
    clock: Clock = utc_now
    _versions: dict[int, Study] = field(default_factory=dict)

    def find_study(self, study_id: str) -> Study:
        """The study that can be joined under this id; raises `UnknownStudy`."""
        if study_id not in self.studies:
            raise UnknownStudy(study_id)
        return self.studies[study_id]

    async def register_studies(self) -> None:
        """Store the current version of every study."""
        async with self.database.writing() as session:
            for study in self.studies.values():
                await keep_version(session, study, self.clock())

    async def join(self, study_id: str, nonce: str, panel: Mapping[str, str]) -> str:
        """Token of whoever sent this landing page; sent twice, it is one participant.

        A person whom the panel names is one participant, too, however often they come. Raises
        `PanelIdRefused`, or `TookPartAlready` if that participation is over.
        """
        study = self.find_study(study_id)
        panel_ids = study.panel.read_ids(panel)
        person_id = study.panel.person_id(panel_ids)
        token = derive_token(self.secret_key, study_id, nonce)
        if person_id is not None:
            token = derive_panel_token(self.secret_key, study_id, study.recruiting, person_id)
        now = self.clock()
        async with self.database.writing() as session:
            version = await keep_version(session, study, now)
            newcomer = NewParticipant(
                token=token,
                study_version_id=version,
                study_id=study_id,
                mode=study.recruiting,
                is_bot=False,
                progress=start(study.plan),
                panel_ids=panel_ids,
            )
            await renew_token(session, newcomer, study.panel)
            await add_participant(session, newcomer, now)
            joined = await find_participant(session, token)
            if person_id is not None and joined.progress.outcome is not None:
                raise TookPartAlready
        return token

    def check_link(self, study: Study, query: Mapping[str, str]) -> dict[str, str]:
        """The panel's parameters in a join link; raises `PanelIdRefused`."""
        return study.panel.read_ids(query)

    async def find_way_back(self, token: str) -> str | None:
        """The panel's address for how this participation ended; None while it is under way.

        Only addresses of hosts that the study names are ever given.
        """
        visit = await self.look_up(token)
        life = visit.participant.progress.life
        if life.outcome is None:
            return None
        ending = visit.study.endings.get(cast("Outcome", life.told))
        if ending is None or ending.host not in visit.study.panel.hosts:
            return None
        async with self.database.reading() as session:
            panel_ids = await read_panel_ids(session, visit.participant.id)
        return ending.address(panel_ids)

    async def visit(self, token: str) -> Visit:
        """Who is at the door; notes that the page of the current step was shown."""
        _check_token(token)
        async with self.database.writing() as session:
            participant = await find_participant(session, token)
            await note_shown(session, participant.id, self.clock())
            if participant.progress.life.status == "paused":
                participant = await find_participant(session, token, lock=True)
                await welcome_back(session, [participant], self.clock())
        return Visit(participant, await self._study_of(participant))

    async def look_up(self, token: str) -> Visit:
        """Who is at the door, without noting anything."""
        _check_token(token)
        async with self.database.reading() as session:
            participant = await find_participant(session, token)
        return Visit(participant, await self._study_of(participant))

    async def submit(self, token: str, step: str, form: Mapping[str, str]) -> None:
        """Store a form and move on.

        The same answers sent again to a step that is behind are welcome and change nothing; any
        other form for another step raises `WrongStep`. Raises `AnswerError` for unfit answers.
        """
        visit = await self.look_up(token)
        kind, _ = step_kind(step)
        now = self.clock()
        async with self.database.writing() as session:
            participant = await find_participant(session, token, lock=True)
            plan, progress = visit.study.plan, participant.progress
            if step != progress.page:
                stored = await read_answers(session, participant.id, step)
                if comes_before(plan, step, progress) and _is_repeat(visit, kind, form, stored):
                    return
                raise WrongStep(step, progress.page)
            answers = _validate(visit, kind, form)
            await move(session, visit.study, participant, FormSent(step), now)
            times = (participant.step_shown_at, now)
            await add_answers(session, participant.id, step, answers, times)

    async def withdraw(self, token: str) -> None:
        """End the participation; doing so twice is the same as once."""
        visit = await self.look_up(token)
        async with self.database.writing() as session:
            participant = await find_participant(session, token, lock=True)
            await move(session, visit.study, participant, Withdrawal(), self.clock())

    async def sweep(self) -> int:
        """End participations idle for too long, note who is away; returns how many ended."""
        ended = 0
        for study in self.studies.values():
            async with self.database.writing() as session:
                ended += await end_idle(session, study, self.clock())
                await pause_absent(session, study, self.clock())
        return ended

    async def _study_of(self, participant: ParticipantRecord) -> Study:
        version = participant.study_version_id
        if version not in self._versions:
            async with self.database.reading() as session:
                self._versions[version] = await read_version(session, version)
        return self._versions[version]


def _check_token(token: str) -> None:
    if not looks_like_token(token):
        raise UnknownToken


def _validate(visit: Visit, kind: str, form: Mapping[str, str]) -> dict[str, str]:
    if kind == "browser-check":
        return judge_device(form)
    items = [item for instrument in visit.instruments(kind) for item in instrument.items]
    return validate_answers(items, form)


def _is_repeat(visit: Visit, kind: str, form: Mapping[str, str], stored: Mapping[str, str]) -> bool:
    """Whether a form says again what is stored. Measurements of the browser may differ."""
    if kind in ("practice", "trial", "debrief"):
        return False
    if kind == "browser-check":
        return True
    try:
        return _validate(visit, kind, form) == stored
    except AnswerError:
        return False
