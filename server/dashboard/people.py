"""Who is under way and where, from the database and the live loop together."""

from __future__ import annotations

from typing import Any

from server.dashboard.watch import LiveWatch, RoomState
from server.store.dashboard import Player, list_players
from server.store.engine import Database

SHOWN = 200


async def describe_people(database: Database, watch: LiveWatch, study_id: str) -> dict[str, Any]:
    """Rows of those heard of last, how many there are in all, and the loop's figures; as JSON."""
    async with database.reading() as session:
        players, total = await list_players(session, study_id, limit=SHOWN)
    loop = watch.judge_loop()
    return {
        "type": "people",
        "total": total,
        "rooms": loop.rooms,
        "running": loop.running,
        "late_p99_ms": round(loop.late_p99_ms, 1),
        "storage_failing_s": loop.storage_failing_s,
        "rows": [_row(player, watch.describe(player.trial_id or "")) for player in players],
    }


def _row(player: Player, room: RoomState | None) -> dict[str, Any]:
    person = player.participant
    return {
        "code": person.code,
        "mode": person.mode,
        "status": person.progress.life.status,
        "step": person.progress.step,
        "seen": f"{person.seen_at:%Y-%m-%dT%H:%M:%SZ}",
        "trial": player.trial_id or "",
        "condition": player.condition,
        "connection": _connection(player, room),
        "phase": "" if room is None else room.phase,
        "time": "" if room is None else f"{room.seconds:.0f} of {room.cap_s:.0f} s",
        "wait": "" if room is None else f"{room.sum_wait_s:.0f} s",
        "boxes": "" if room is None else f"{room.boxes} of {room.boxes_total}",
    }


def _connection(player: Player, room: RoomState | None) -> str:
    if room is None:
        return "not back yet" if player.trial_id else "on a page"
    if room.is_connected:
        return "connected"
    return f"away for {room.absent_s:.0f} s of {room.abandon_after_s:.0f} s"
