"""What staff do with participations: look at their history, exclude, reinstate, erase.

Each method is one transaction, written to the audit log with it.
"""

from __future__ import annotations

from dataclasses import dataclass

from server.desks.trials import Clock, utc_now
from server.store.audit import add_audit
from server.store.engine import Database
from server.store.lives import StatusChange, erase_data, list_changes
from server.store.moves import alter
from server.store.participants import ParticipantRecord, find_by_code
from study.errors import WrongMoment
from study.protocol.lifecycle import Act, check_reason

KEPT = (
    "the participant code, study version, mode, step reached, place in the design, and when the "
    "participation began, changed and ended"
)
"""What an erasure leaves, in words for whoever asked."""


class AlreadyErased(WrongMoment):
    """There is nothing left of this participant but the tombstone."""

    def __init__(self, code: str) -> None:
        self.code = code
        super().__init__(
            f"the data of {code} were erased before",
            next_step="Nothing is left of them that could be changed.",
        )


@dataclass(frozen=True)
class LifeDesk:
    """Owns the transactions in which staff change participations."""

    database: Database
    clock: Clock = utc_now

    async def read_history(self, code: str) -> tuple[ParticipantRecord, list[StatusChange]]:
        """The participant with this code and all changes; raises `UnknownParticipant`."""
        async with self.database.reading() as session:
            participant = await find_by_code(session, code)
            return participant, await list_changes(session, participant.id)

    async def exclude(self, code: str, reason: str, user_name: str) -> None:
        """Take a participant out of the analysis and give their place back.

        Raises `UnknownParticipant`, `WrongChange`, or InvalidValue without a reason.
        """
        await self._alter(code, "exclude", reason, user_name)

    async def reinstate(self, code: str, reason: str, user_name: str) -> None:
        """Take an exclusion back; raises as `exclude` does."""
        await self._alter(code, "reinstate", reason, user_name)

    async def erase(self, code: str, user_name: str) -> dict[str, int]:
        """Withdraw a participant and delete their data; returns deleted rows by table.

        Raises `UnknownParticipant` or `AlreadyErased`.
        """
        now = self.clock()
        async with self.database.writing() as session:
            participant = await find_by_code(session, code, lock=True)
            if participant.erased_at is not None:
                raise AlreadyErased(participant.code)
            await alter(session, participant, "withdraw", ("asked for erasure", user_name), now)
            gone = await erase_data(session, participant.id, now)
            await add_audit(session, user_name, "participant erased", participant.code, now)
        return gone

    async def _alter(self, code: str, act: Act, reason: str, user_name: str) -> None:
        now, why = self.clock(), check_reason(reason)
        async with self.database.writing() as session:
            participant = await find_by_code(session, code, lock=True)
            if participant.erased_at is not None:
                raise AlreadyErased(participant.code)
            await alter(session, participant, act, (why, user_name), now)
            detail = f"{participant.code}: {why}"
            await add_audit(session, user_name, f"participant {act}d", detail, now)
