"""A worker's link on its way from where it is made to the one page that shows it.

The token is stored hashed, so it is carried by a signed cookie of that page, which is taken away
once it was shown.
"""

from __future__ import annotations

from itsdangerous import BadSignature, URLSafeTimedSerializer

COOKIE = "varil_worker_link"
KEPT_S = 300


class WorkerLinks:
    """Seals and opens the cookie."""

    def __init__(self, secret_key: bytes) -> None:
        self._serializer = URLSafeTimedSerializer(secret_key, salt="worker link")

    def seal(self, run_id: str, token: str) -> str:
        """The cookie's value for the token of this run's worker."""
        return self._serializer.dumps([run_id, token])

    def open(self, run_id: str, cookie: str) -> str | None:
        """The token in a cookie, or None if it is not ours, too old, or another run's."""
        try:
            sealed_for, token = self._serializer.loads(cookie, max_age=KEPT_S)
        except (BadSignature, ValueError, TypeError):
            return None
        return token if sealed_for == run_id and isinstance(token, str) else None
