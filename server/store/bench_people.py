"""A large finished study for the benchmark of the export: rows as many and as long as real ones."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from typing import Any

from sqlalchemy import insert, select
from sqlalchemy.ext.asyncio import AsyncSession

from server.store.engine import Database
from server.store.studies import keep_version
from server.store.tables import (
    Participant,
    ParticipantChange,
    Response,
    Trial,
    TrialEvent,
    TrialLeg,
    TrialQuality,
    TrialRobot,
)
from study.config import Study

ROBOTS, LEGS_PER_ROBOT, WORLD_EVENTS, DISPLAYS, REPORTS = 12, 13, 204, 300, 60
START = datetime(2026, 1, 1, tzinfo=UTC)
_MEASURES = {
    "duration_s": 312.4,
    "sum_wait_s": 481.23333333333335,
    "sum_completion_s": 3391.8,
    "slowest_robot_s": 312.4,
    "human_path_m": 291.0341,
    "human_still_s": 61.7,
    "blocked_by_human_s": 9.4,
    "boxes_delivered": 36,
    "longest_stall_s": 6.2,
    "overlaps": 0,
}
_QUALITY = {
    "rtt_median_ms": 31.2,
    "rtt_p95_ms": 58.4,
    "frame_rate_median_hz": 60.0,
    "frame_rate_p5_hz": 52.0,
    "long_frames": 3,
    "longest_frame_ms": 83.0,
    "hidden_s": 0.0,
    "unfocused_s": 1.25,
    "pointer_lock_losses": 1,
    "pauses": 0,
    "paused_s": 0.0,
    "idle_s": 5.5,
    "tick_late_p99_ms": 1.75,
    "tick_late_max_ms": 9.1,
    "connections": 1,
    "reports": REPORTS,
}


async def add_bench_people(database: Database, study: Study, people: int) -> None:
    """So many completed participants, each with all trials and answers, as bots."""
    async with database.writing() as session:
        version = await keep_version(session, study, START)
        numbers = range(1, people + 1)
        await session.execute(insert(Participant), [_person(n, version, study) for n in numbers])
        await session.execute(insert(ParticipantChange), [_change(n) for n in numbers])
        for first in range(1, people + 1, 100):
            some = range(first, min(first + 100, people + 1))
            await session.execute(
                insert(Response), [row for n in some for row in _answers(n, study)]
            )
        trials = [row for n in numbers for row in _trials(n, study)]
        await session.execute(insert(Trial), trials)
        await _fill_trials(session, trials[0]["id"])


async def _fill_trials(session: AsyncSession, first: str) -> None:
    """Give one trial its rows, then every other the same ones."""
    at = START.replace(microsecond=123000)
    await session.execute(
        insert(TrialRobot),
        [
            {"trial_id": first, "robot": k, "boxes_delivered": 3, "wait_s": 40.1, "path_m": 151.2}
            | {"completion_s": 300.2, "longest_stall_s": 5.1, "blocked_by_human_s": 0.7}
            for k in range(ROBOTS)
        ],
    )
    await session.execute(
        insert(TrialLeg),
        [
            {"trial_id": first, "robot": k, "leg": n, "state": "to_shelf", "start_s": n * 20.1}
            | {"end_s": n * 20.1 + 20.1, "path_m": 11.73, "shelf": 17, "box": 3, "ended": True}
            for k in range(ROBOTS)
            for n in range(LEGS_PER_ROBOT)
        ],
    )
    await session.execute(insert(TrialEvent), [_event(first, n, at) for n in range(_EVENTS)])
    await session.execute(insert(TrialQuality), [{"trial_id": first} | _QUALITY])
    for table in (TrialRobot, TrialLeg, TrialEvent, TrialQuality):
        columns = table.__table__.columns
        rest = [columns[name] for name in columns.keys() if name != "trial_id"]  # noqa: SIM118
        copies = (
            select(Trial.id, *rest)
            .join_from(table, Trial, Trial.id != first)
            .where(columns["trial_id"] == first)
        )
        await session.execute(
            insert(table).from_select(["trial_id", *(column.name for column in rest)], copies)
        )


_EVENTS = WORLD_EVENTS + DISPLAYS + REPORTS


def _event(trial_id: str, number: int, at: datetime) -> dict[str, Any]:
    kind, data = "box_delivered", {"robot": number % ROBOTS, "colour": 2, "station": 1}
    if number % 2 and number < 2 * DISPLAYS:
        kind = "display_decided"
        data = {"robots": "07" * ROBOTS, "stations": "0101", "overlays": 0}  # type: ignore[dict-item]
    elif number % 9 == 0:
        kind, data = "quality", {"fps": "60 60 59 60 60", "rtt_ms": "31.2 30.8"}  # type: ignore[dict-item]
    moment = at + timedelta(seconds=number / 2)
    row = {"trial_id": trial_id, "number": number, "tick": number * 15, "kind": kind}
    return row | {"at": moment, "data": data}


def _person(number: int, version: int, study: Study) -> dict[str, Any]:
    return {
        "id": number,
        "code": f"P-B{number:07d}",
        "token_hash": f"bench-{number}",
        "study_version_id": version,
        "study_id": study.study_id,
        "mode": "bot",
        "is_bot": True,
        "step": "debrief",
        "practice_tries": 1,
        "status": "completed",
        "block": number // len(study.orders),
        "order_index": number % len(study.orders),
        "joined_at": START,
        "seen_at": START,
        "ended_at": START + timedelta(minutes=40),
    }


def _change(number: int) -> dict[str, Any]:
    change = {"participant_id": number, "at": START, "from_status": None, "to_status": "completed"}
    return change | {"reason": "did every step", "actor": "participant"}


def _answers(number: int, study: Study) -> list[dict[str, Any]]:
    asked = [("consent", item.name) for item in study.consent.items]
    asked += [("demographics", item.name) for item in study.demographics.items]
    asked += [(f"questionnaire-{k}", f"Q{q}") for k in (1, 2, 3) for q in range(1, 7)]
    asked += [("comments", "remarks")]
    return [
        {"participant_id": number, "step": step, "item": item, "item_order": order}
        | {"value": "4" if item[0] == "Q" else "some words " * 9, "shown_at": START}
        | {"answered_at": START}
        for order, (step, item) in enumerate(asked, 1)
    ]


def _trials(number: int, study: Study) -> list[dict[str, Any]]:
    order = study.orders[number % len(study.orders)]
    return [
        {
            "id": f"{number:026d}trial{position}",
            "participant_id": number,
            "step": f"trial-{position}",
            "attempt": 1,
            "kind": "trial",
            "position": position,
            "condition": condition,
            "label": f"Display {position}",
            "scale": "study",
            "seed": number,
            "config_hash": study.config_hash,
            "config": {},
            "status": "completed",
            "phase": "finished",
            "ticks": 9372,
            "state_hash": b"\x05" * 8,
            "opened_at": START,
            "ended_at": START,
        }
        | _MEASURES
        for position, condition in enumerate(order, 1)
    ]
