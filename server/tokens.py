"""Participants' tokens: made so that a landing page can be sent twice but joined once.

The landing page carries a random number; the token is a keyed hash of it. Sending the same form
twice therefore leads to the same participant, although nothing was stored when the page was shown.
"""

from __future__ import annotations

import base64
import hashlib
import hmac
import logging
import re
import secrets

_NONCE = re.compile(r"[A-Za-z0-9_-]{22}")
_TOKEN = re.compile(r"[A-Za-z0-9_-]{32}")
_IN_PATH = re.compile(r"(/(?:p|w)/)[^/?#\s\"']+")


def make_nonce() -> str:
    """128 random bits for a landing page."""
    return secrets.token_urlsafe(16)


def derive_token(secret_key: bytes, study_id: str, nonce: str) -> str:
    """The participant's token for this landing page: 192 bits, url-safe.

    Whatever is not a number we could have made counts as none: a new one is drawn.
    """
    if not _NONCE.fullmatch(nonce):
        nonce = make_nonce()
    digest = hmac.digest(secret_key, f"join\x1f{study_id}\x1f{nonce}".encode(), hashlib.sha256)
    return base64.urlsafe_b64encode(digest[:24]).decode()


def derive_panel_token(secret_key: bytes, study_id: str, mode: str, person_id: str) -> str:
    """The token of a person of a recruitment panel: the same whenever they come again."""
    parts = f"panel\x1f{study_id}\x1f{mode}\x1f{person_id}"
    digest = hmac.digest(secret_key, parts.encode(), hashlib.sha256)
    return base64.urlsafe_b64encode(digest[:24]).decode()


def looks_like_token(text: str) -> bool:
    """Whether this could be a token at all."""
    return _TOKEN.fullmatch(text) is not None


def mask_tokens(text: str) -> str:
    """The text with the tokens in addresses replaced."""
    return _IN_PATH.sub(r"\1***", text)


class MaskingFormatter(logging.Formatter):
    """Formats as another formatter would, then masks the tokens; tracebacks included."""

    def __init__(self, inner: logging.Formatter | None) -> None:
        super().__init__()
        self._inner = inner or logging.Formatter()

    def format(self, record: logging.LogRecord) -> str:
        """The finished line without tokens."""
        return mask_tokens(self._inner.format(record))


def mask_server_logs() -> None:
    """Mask what every handler writes, that of last resort included."""
    loggers = [logging.getLogger(), *map(logging.getLogger, ("uvicorn", "uvicorn.access"))]
    handlers = [handler for logger in loggers for handler in logger.handlers]
    for handler in [*handlers, *([logging.lastResort] if logging.lastResort else [])]:
        if not isinstance(handler.formatter, MaskingFormatter):
            handler.setFormatter(MaskingFormatter(handler.formatter))
