"""Simulated participants: issued to staff, and ended when they stay away. Nobody else becomes one.

What a participant is (`mode`, `is_bot`) is written when the row is made and changed by nothing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from server.desks.trials import Clock, utc_now
from server.store.audit import add_audit
from server.store.engine import Database
from server.store.moves import alter
from server.store.participants import (
    NewParticipant,
    add_participant,
    find_by_code,
    find_participant,
)
from server.store.studies import keep_version
from server.tokens import derive_token, make_nonce
from study.config import Study
from study.errors import InvalidValue, UnknownStudy
from study.protocol.flow import start
from study.protocol.lifecycle import REASONS

MODE = "bot"
MOST_AT_ONCE = 1000


@dataclass(frozen=True)
class IssuedBot:
    """A simulated participant: the code in the data, and the token of the personal address."""

    code: str
    token: str


@dataclass(frozen=True)
class BotDesk:
    """Owns the transactions about simulated participants."""

    database: Database
    studies: Mapping[str, Study]
    secret_key: bytes
    clock: Clock = utc_now

    async def issue(self, study_id: str, count: int, user_name: str) -> list[IssuedBot]:
        """Make so many simulated participants of the current version; raises `UnknownStudy`."""
        if study_id not in self.studies:
            raise UnknownStudy(study_id)
        if not 1 <= count <= MOST_AT_ONCE:
            raise InvalidValue(
                f"{count} simulated participants cannot be issued",
                next_step=f"Ask for 1 to {MOST_AT_ONCE} at a time.",
            )
        study, now = self.studies[study_id], self.clock()
        issued = []
        async with self.database.writing() as session:
            version = await keep_version(session, study, now)
            for _ in range(count):
                token = derive_token(self.secret_key, study_id, make_nonce())
                newcomer = NewParticipant(
                    token=token,
                    study_version_id=version,
                    study_id=study_id,
                    mode=MODE,
                    is_bot=True,
                    progress=start(study.plan),
                    panel_ids={},
                )
                await add_participant(session, newcomer, now)
                issued.append(IssuedBot((await find_participant(session, token)).code, token))
            await add_audit(session, user_name, "bots issued", f"{study_id}: {count}", now)
        return issued

    async def time_out(self, study_id: str, codes: Sequence[str], user_name: str) -> int:
        """End these simulated participants as if nothing had been heard of them for the study's
        limit, and give their places back; returns how many. All of them or none.

        Raises `UnknownParticipant`, or InvalidValue for one who is not simulated or elsewhere.
        """
        now = self.clock()
        async with self.database.writing() as session:
            for code in codes:
                bot = await find_by_code(session, code, lock=True)
                if not bot.is_bot or bot.study_id != study_id:
                    raise InvalidValue(
                        f"{bot.code} is no simulated participant of “{study_id}”",
                        next_step="Only simulated participants can be timed out by hand.",
                    )
                await alter(session, bot, "time-out", (REASONS["time-out"], user_name), now)
            detail = f"{study_id}: {len(codes)}"
            await add_audit(session, user_name, "bots timed out", detail, now)
        return len(codes)
