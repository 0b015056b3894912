"""Answers with their times; the database itself refuses a second answer to the same item."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime

from sqlalchemy import select
from sqlalchemy.ext.asyncio import AsyncSession

from server.store.tables import Response


async def add_answers(
    session: AsyncSession,
    participant_id: int,
    step: str,
    answers: Mapping[str, str],
    times: tuple[datetime | None, datetime],
) -> None:
    """Store the answers of a step; `times` are when it was shown and when it was sent."""
    shown_at, answered_at = times
    session.add_all(
        Response(
            participant_id=participant_id,
            step=step,
            item=item,
            item_order=number,
            value=value,
            shown_at=shown_at,
            answered_at=answered_at,
        )
        for number, (item, value) in enumerate(answers.items(), 1)
    )
    await session.flush()


async def read_answers(session: AsyncSession, participant_id: int, step: str) -> dict[str, str]:
    """Stored values of a step by item, in the order shown; empty if nothing was sent."""
    rows = await session.execute(
        select(Response.item, Response.value)
        .where(Response.participant_id == participant_id, Response.step == step)
        .order_by(Response.item_order)
    )
    return {item: value for item, value in rows}  # noqa: C416
