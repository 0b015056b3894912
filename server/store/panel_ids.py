"""What recruitment panels call participants; apart from all research data."""

from __future__ import annotations

from typing import Any

from sqlalchemy import func, select, update
from sqlalchemy.ext.asyncio import AsyncSession

from server.store.participants import NewParticipant, hash_token
from server.store.tables import PanelId, Participant
from study.protocol.panel import Panel


async def renew_token(session: AsyncSession, new: NewParticipant, panel: Panel) -> None:
    """Give a person of the panel who has joined before the token that they have now.

    It is another one only if the server's secret key was changed since.
    """
    person_id = panel.person_id(new.panel_ids)
    if person_id is None:
        return
    value: Any = func.lower(PanelId.value) if panel.ignore_case else PanelId.value
    known = (
        select(PanelId.participant_id)
        .join(Participant, Participant.id == PanelId.participant_id)
        .where(
            PanelId.name == panel.person_parameter,
            value == person_id,
            Participant.study_id == new.study_id,
            Participant.mode == new.mode,
        )
        .order_by(PanelId.participant_id)
        .limit(1)
    )
    found = await session.scalar(known)
    if found is not None:
        await session.execute(
            update(Participant)
            .where(Participant.id == found, Participant.token_hash != hash_token(new.token))
            .values(token_hash=hash_token(new.token))
        )


async def read_panel_ids(session: AsyncSession, participant_id: int) -> dict[str, str]:
    """What the panel calls this participant, by parameter."""
    rows = await session.execute(
        select(PanelId.name, PanelId.value).where(PanelId.participant_id == participant_id)
    )
    return {name: value for name, value in rows}  # noqa: C416
