"""Simulated participants: issued, and ended when they stay away. Administrators only."""

from __future__ import annotations

from fastapi import APIRouter

from server.api.records import Bot, BotCodes, BotOrder, Bots, Ended, Name
from server.deps import AdminDep, ServicesDep

router = APIRouter(prefix="/api/v1/studies/{study_id}/bots", tags=["bots"])


@router.post("", status_code=201)
async def issue_bots(
    study_id: Name, order: BotOrder, services: ServicesDep, user: AdminDep
) -> Bots:
    """Issue simulated participants; their worlds run in lock-step, their rows say `bot`."""
    issued = await services.bots.issue(study_id, order.count, user.name)
    return Bots(bots=[Bot(code=bot.code, address=f"/p/{bot.token}") for bot in issued])


@router.post("/time-out")
async def time_out_bots(
    study_id: Name, codes: BotCodes, services: ServicesDep, user: AdminDep
) -> Ended:
    """End simulated participants who stay away, so that their places are free again."""
    return Ended(ended=await services.bots.time_out(study_id, codes.codes, user.name))
