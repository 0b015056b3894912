"""Rows of the export as plain values, a page at a time: a table is never held as a whole.

Of people who withdrew only the row in `participants` is given: their data are not to be used.
"""

from __future__ import annotations

from collections.abc import AsyncIterator, Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from operator import itemgetter
from types import MappingProxyType
from typing import Any, Literal

from sqlalchemy import Text, cast, func, select
from sqlalchemy.ext.asyncio import AsyncSession

from server.store.tables import (
    LearningPair,
    LearningRun,
    LearningVersion,
    PanelId,
    Participant,
    ParticipantChange,
    Response,
    StaffNote,
    StudyVersion,
    Trial,
    TrialEvent,
    TrialLeg,
    TrialQuality,
    TrialRobot,
)

PEOPLE_PER_PAGE = 100
TRIALS_PER_PAGE = 10
LABELS_PER_PAGE = 2000
ORIGIN = ("participant_code", "study_id", "config_hash", "mode", "is_bot")

Row = dict[str, Any]
Pages = AsyncIterator[list[Row]]
Part = Literal["robots", "legs", "events", "quality"]

_PARTS: Mapping[Part, tuple[type[Any], tuple[str, ...]]] = MappingProxyType(
    {
        "robots": (TrialRobot, ("robot",)),
        "legs": (TrialLeg, ("robot", "leg")),
        "events": (TrialEvent, ("number",)),
        "quality": (TrialQuality, ()),
    }
)


@dataclass(frozen=True)
class Selection:
    """Whose rows: those of a study, of one mode or (None) of all."""

    study_id: str
    mode: str | None = None


async def people_pages(session: AsyncSession, chosen: Selection) -> Pages:
    """Everybody in the order of joining, with how they stand, why, and their place."""
    reason = (
        select(ParticipantChange.reason)
        .where(ParticipantChange.participant_id == Participant.id)
        .order_by(ParticipantChange.id.desc())
        .limit(1)
        .scalar_subquery()
    )
    query = (
        select(
            Participant.id.label("participant_id"),
            Participant.code.label("participant_code"),
            Participant.study_id,
            StudyVersion.config_hash.label("config_hash"),
            Participant.mode,
            Participant.is_bot,
            Participant.status,
            reason.label("status_reason"),
            Participant.order_index,
            Participant.step,
            Participant.block,
            Participant.practice_tries,
            Participant.joined_at,
            Participant.ended_at,
            Participant.erased_at,
        )
        .join(StudyVersion, StudyVersion.id == Participant.study_version_id)
        .where(Participant.study_id == chosen.study_id)
    )
    if chosen.mode is not None:
        query = query.where(Participant.mode == chosen.mode)
    last = 0
    while True:
        page = query.where(Participant.id > last).order_by(Participant.id).limit(PEOPLE_PER_PAGE)
        rows = await _fetch(session, page)
        if not rows:
            return
        last = rows[-1]["participant_id"]
        yield rows


async def trials_of(session: AsyncSession, people: Collection[Row]) -> list[Row]:
    """Their trials after the practice, by person and position."""
    kept = _kept(people)
    query = (
        select(
            Trial.participant_id,
            Trial.id.label("trial_id"),
            Trial.position,
            Trial.condition,
            Trial.scale,
            Trial.seed,
            Trial.policy_sha256,
            Trial.status,
            Trial.ticks,
            Trial.duration_s,
            Trial.sum_wait_s,
            Trial.sum_completion_s,
            Trial.slowest_robot_s,
            Trial.human_path_m,
            Trial.human_still_s,
            Trial.blocked_by_human_s,
        )
        .where(Trial.participant_id.in_(list(kept)), Trial.kind == "trial")
        .order_by(Trial.participant_id, Trial.position)
    )
    return [_origin(kept[row["participant_id"]]) | row for row in await _fetch(session, query)]


async def answers_of(session: AsyncSession, people: Collection[Row]) -> list[Row]:
    """Their answers in the order given, with the order index that tells the condition."""
    kept = _kept(people)
    query = (
        select(
            Response.participant_id,
            Response.step,
            Response.item,
            Response.item_order,
            Response.value,
            Response.shown_at,
            Response.answered_at,
        )
        .where(Response.participant_id.in_(list(kept)))
        .order_by(Response.participant_id, Response.id)
    )
    return [
        _origin(person := kept[row["participant_id"]])
        | {"order_index": person["order_index"]}
        | row
        for row in await _fetch(session, query)
    ]


async def panel_ids_of(session: AsyncSession, people: Collection[Row]) -> list[Row]:
    """What the panel calls them; kept also of those who withdrew, who may have to be paid."""
    known = {row["participant_id"]: row for row in people}
    query = (
        select(PanelId.participant_id, PanelId.name, PanelId.value)
        .where(PanelId.participant_id.in_(list(known)))
        .order_by(PanelId.participant_id, PanelId.name)
    )
    return [_origin(known[row["participant_id"]]) | row for row in await _fetch(session, query)]


async def notes_of(session: AsyncSession, people: Collection[Row]) -> list[Row]:
    """What staff noted about them, by person in the order written; by whom is not told."""
    kept = _kept(people)
    query = (
        select(
            StaffNote.participant_id,
            StaffNote.trial_id,
            Trial.step,
            StaffNote.tick,
            StaffNote.text,
            StaffNote.at.label("written_at"),
        )
        .join(Trial, Trial.id == StaffNote.trial_id, isouter=True)
        .where(StaffNote.participant_id.in_(list(kept)))
        .order_by(StaffNote.participant_id, StaffNote.id)
    )
    return [_origin(kept[row["participant_id"]]) | row for row in await _fetch(session, query)]


async def parts_of(session: AsyncSession, trials: Sequence[Row], part: Part) -> list[Row]:
    """Robots, legs, events or quality of some trials, in the order of the trials."""
    table, order = _PARTS[part]
    columns = [column for column in table.__table__.columns if column.name != "data"]
    if part == "events":
        columns.append(cast(TrialEvent.data, Text).label("data"))
    places = [table.__table__.columns[name] for name in ("trial_id", *order)]
    query = (
        select(*columns)
        .where(table.trial_id.in_([trial["trial_id"] for trial in trials]))
        .order_by(*places)
    )
    found = {
        trial_id: list(rows)
        for trial_id, rows in groupby(await _fetch(session, query), itemgetter("trial_id"))
    }
    parts = []
    for trial in trials:
        origin = _origin(trial)
        parts += [origin | row for row in found.get(trial["trial_id"], ())]
    return parts


async def label_pages(session: AsyncSession, policies: Collection[str]) -> Pages:
    """Pairs of the live learning runs that these policies come from, up to each one's iteration."""
    latest = (
        select(LearningVersion.run_id, func.max(LearningVersion.iteration).label("iteration"))
        .where(LearningVersion.policy_sha256.in_(list(policies)), LearningVersion.iteration > 0)
        .group_by(LearningVersion.run_id)
        .order_by(LearningVersion.run_id)
    )
    for run_id, iteration in (await session.execute(latest)).all():
        worker = await session.scalar(select(LearningRun.worker).where(LearningRun.id == run_id))
        last = -1
        while True:
            page = (
                select(*LearningPair.__table__.columns)
                .where(
                    LearningPair.run_id == run_id,
                    LearningPair.number > last,
                    LearningPair.iteration < iteration,
                )
                .order_by(LearningPair.number)
                .limit(LABELS_PER_PAGE)
            )
            rows = await _fetch(session, page)
            if not rows:
                break
            last = rows[-1]["number"]
            yield [row | {"is_bot": worker == "simulated"} for row in rows]


async def _fetch(session: AsyncSession, query: Any) -> list[Row]:
    return [dict(row) for row in (await session.execute(query)).mappings()]


def _kept(people: Collection[Row]) -> dict[int, Row]:
    return {row["participant_id"]: row for row in people if row["status"] != "withdrawn"}


def _origin(row: Row) -> Row:
    return {name: row[name] for name in ORIGIN}
