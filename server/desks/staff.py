"""What administrators do to participants and are told of a study, each one transaction."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import timedelta

from server.dashboard.watch import LONGEST_EXTENSION_S, LiveWatch
from server.desks.lives import AlreadyErased
from server.desks.policies import PolicyDesk, needs_confirmation
from server.desks.trials import Clock, utc_now
from server.store.audit import add_audit
from server.store.dashboard import count_away, count_crowds
from server.store.engine import Database
from server.store.moves import PAUSED_AFTER_S
from server.store.participants import find_by_code, give_time, read_participant
from server.store.stories import LONGEST_NOTE, Note, add_note
from server.store.trials import TrialRecord, UnknownTrial, read_trial, store_limit
from study.config import Study
from study.errors import InvalidValue
from study.protocol.alarms import Alarm, VitalSigns, raise_alarms
from study.protocol.balance import Cell, fill_cells, foresee, spread
from study.protocol.consort import ParticipantFlow, count_drop_out, count_flow
from study.protocol.lifecycle import Act, Life, change


@dataclass(frozen=True)
class Summary:
    """A study in one mode: its flow, its cells and what is wrong."""

    flow: ParticipantFlow
    cells: tuple[Cell, ...]
    alarms: tuple[Alarm, ...]
    modes: dict[str, int]


@dataclass(frozen=True)
class Preview:
    """What excluding or reinstating somebody does to their cell; None for who has none."""

    act: Act
    to_status: str
    before: Cell | None
    after: Cell | None
    spread_before: int
    spread_after: int


@dataclass(frozen=True)
class AdminDesk:
    """Owns the transactions of the administrators' pages."""

    database: Database
    policies: PolicyDesk
    watch: LiveWatch
    time_scale: float
    clock: Clock = utc_now

    async def sum_up(self, study: Study, mode: str) -> Summary:
        """The study's flow, cells and alarms in one mode."""
        now = self.clock()
        async with self.database.reading() as session:
            everybody = await count_crowds(session, study.study_id)
            away_before = now - timedelta(seconds=PAUSED_AFTER_S)
            away = await count_away(session, study.study_id, mode, away_before)
        modes: dict[str, int] = {}
        for crowd in everybody:
            modes[crowd.mode] = modes.get(crowd.mode, 0) + crowd.number
        crowds = [crowd for crowd in everybody if crowd.mode == mode]
        flow = count_flow(crowds, len(study.conditions))
        cells = fill_cells(crowds, study.orders, study.planned_participants)
        active = await self.policies.find_active(study)
        loop, drop_out = self.watch.judge_loop(), count_drop_out(flow)
        signs = VitalSigns(
            storage_failing_s=loop.storage_failing_s,
            late_p99_ms=loop.late_p99_ms,
            ticks=loop.ticks,
            away=away,
            drop_out=drop_out.share,
            judged=drop_out.judged,
            spread=spread(cells),
            is_live=study.recruiting == "live",
            policy_is_simulated=active is not None and needs_confirmation(active.policy, study),
            time_scale=self.time_scale,
        )
        return Summary(flow, cells, tuple(raise_alarms(signs)), modes)

    async def preview(self, study: Study, code: str) -> Preview | None:
        """What excluding this participant, or reinstating one excluded, would do to the cells.

        None for one who withdrew: that is final. Raises `UnknownParticipant`.
        """
        async with self.database.reading() as session:
            person = await find_by_code(session, code)
            crowds = await count_crowds(session, study.study_id)
        life = person.progress.life
        if life.status == "withdrawn" or person.erased_at is not None:
            return None
        act: Act = "reinstate" if life.status == "excluded" else "exclude"
        after = change(life, act)
        mine = [crowd for crowd in crowds if crowd.mode == person.mode]
        cells = fill_cells(mine, study.orders, study.planned_participants)
        if person.slot is None or person.slot.order_index >= len(cells):
            return Preview(act, after.status, None, None, spread(cells), spread(cells))
        order = person.slot.order_index
        then = foresee(
            cells,
            order,
            completed=_completed(after) - _completed(life),
            under_way=_under_way(after) - _under_way(life),
        )
        return Preview(act, after.status, cells[order], then[order], spread(cells), spread(then))

    async def note(self, code: str, text: str, user_name: str) -> None:
        """Keep a note about a participant.

        Raises `UnknownParticipant`, `AlreadyErased` or InvalidValue.
        """
        now, words = self.clock(), check_note(text)
        async with self.database.writing() as session:
            person = await find_by_code(session, code, lock=True)
            if person.erased_at is not None:
                raise AlreadyErased(person.code)
            await add_note(session, person.id, Note(now, user_name, words, None, None))
            await add_audit(session, user_name, "note written", person.code, now)

    async def note_trial(self, trial_id: str, tick: int, text: str, user_name: str) -> None:
        """Keep a note about a moment of a trial; one after its last tick is about that tick.

        Raises `UnknownTrial` or InvalidValue.
        """
        now, words = self.clock(), check_note(text)
        async with self.database.writing() as session:
            trial = await read_trial(session, trial_id)
            person = await read_participant(session, owner_of(trial))
            last = max(trial.ticks, self.watch.last_tick(trial.id))
            note = Note(now, user_name, words, trial.id, min(tick, last))
            await add_note(session, person.id, note)
            detail = f"{person.code}: {trial.step} at tick {note.tick}"
            await add_audit(session, user_name, "note written", detail, now)

    async def extend(self, trial_id: str, minutes: int, user_name: str) -> None:
        """Wait longer for an absent participant: in the database, then in memory.

        The new limit is stored with the trial, so a restarted server keeps it, and what two people
        add at once adds up. Raises `UnknownTrial` or `NotRunning`.
        """
        now, more_s = self.clock(), min(minutes * 60.0, LONGEST_EXTENSION_S)
        self.watch.require_running(trial_id)
        async with self.database.writing() as session:
            owner = owner_of(await read_trial(session, trial_id))
            person = await read_participant(session, owner, lock=True)
            trial = await read_trial(session, trial_id, lock=True)
            limit_s = trial.config["abandon_after_s"] + more_s
            await store_limit(session, trial, limit_s)
            await give_time(session, person.id, now + timedelta(seconds=limit_s))
            detail = f"{person.code}: {trial.step}, {minutes} minutes more"
            await add_audit(session, user_name, "time extended", detail, now)
        self.watch.set_limit(trial_id, limit_s)


def owner_of(trial: TrialRecord) -> int:
    """The participant of a trial; raises `UnknownTrial` for one of a learning run."""
    if trial.participant_id is None:
        raise UnknownTrial(trial.id)
    return trial.participant_id


def check_note(text: str) -> str:
    """A note in tidy lines; raises InvalidValue if it is empty or too long."""
    words = text.replace("\x00", "").strip()
    if not words or len(words) > LONGEST_NOTE:
        raise InvalidValue(
            f"a note has 1 to {LONGEST_NOTE} characters, this one has {len(words)}",
            next_step="Nothing was stored. Shorten it or write it in two.",
        )
    return words


def _completed(life: Life) -> int:
    return int(life.status == "completed")


def _under_way(life: Life) -> int:
    return int(life.outcome is None)
