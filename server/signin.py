"""Staff sign-in: the signed cookie and the limit on attempts."""

from __future__ import annotations

from itsdangerous import BadSignature, URLSafeTimedSerializer
from limits import RateLimitItemPerMinute
from limits.aio.storage import MemoryStorage
from limits.aio.strategies import MovingWindowRateLimiter

from server.problems import TooOften
from server.store.users import StaffRecord

COOKIE = "varil_staff"
SESSION_S = 12 * 3600
_PER_NAME = RateLimitItemPerMinute(5)
_PER_HOST = RateLimitItemPerMinute(20)


class SignIns:
    """Makes and reads sign-in cookies, and counts attempts (in memory only)."""

    def __init__(self, secret_key: bytes) -> None:
        self._serializer = URLSafeTimedSerializer(secret_key, salt="staff sign-in")
        self._attempts = MovingWindowRateLimiter(MemoryStorage())

    async def count_attempt(self, name: str, host: str) -> None:
        """Raise `TooOften` if there were too many attempts within a minute."""
        name_free = await self._attempts.hit(_PER_NAME, "name", name[:64].lower(), host)
        host_free = await self._attempts.hit(_PER_HOST, "host", host)
        if not (name_free and host_free):
            raise TooOften(60)

    def sign(self, user: StaffRecord) -> str:
        """The cookie's value for a signed-in account."""
        return self._serializer.dumps([user.id, user.session_key])

    def read(self, cookie: str) -> tuple[int, str] | None:
        """Account id and session key of a cookie, or None if it is not ours or too old."""
        try:
            user_id, key = self._serializer.loads(cookie, max_age=SESSION_S)
        except (BadSignature, ValueError, TypeError):
            return None
        return (user_id, key) if isinstance(user_id, int) and isinstance(key, str) else None
