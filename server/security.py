"""What stands between the network and every route: headers, origin check, size limit, last net.

Pure ASGI, outermost, so that no answer leaves without its headers, error pages included.
"""

from __future__ import annotations

import logging
import secrets
from collections.abc import Awaitable, Callable, Iterable
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import Request
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from server.problems import ForeignOrigin, TooLarge
from study.errors import StudyError

BODY_LIMIT_BYTES = 64 * 1024
SAFE_METHODS = frozenset({"GET", "HEAD", "OPTIONS"})
CONTENT_SECURITY_POLICY = "; ".join(
    (
        "default-src 'self'",
        "script-src 'self'",
        "style-src 'self'",
        "img-src 'self' data:",
        "connect-src 'self'",
        "object-src 'none'",
        "frame-ancestors 'none'",
        "base-uri 'none'",
        "form-action 'self'",
        "require-trusted-types-for 'script'",
    )
)
HEADERS = {
    "Content-Security-Policy": CONTENT_SECURITY_POLICY,
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), microphone=(), geolocation=(), payment=(), usb=()",
}

ErrorPage = Callable[[Request, Exception, str], Awaitable[Response]]
log = logging.getLogger("varil.server")


def same_origin(headers: Headers, allowed_origins: Iterable[str] = ()) -> bool:
    """Whether a request or socket was started by our own pages, as its browser tells.

    `Sec-Fetch-Site` decides where it is sent (https and localhost); a foreign `Origin` is refused
    in any case, and `null` wherever nothing else vouches for it. Without any sign (no browser
    sends an unsafe request so) there is nothing of a victim's to misuse.
    """
    site = headers.get("sec-fetch-site")
    if site is not None and site not in ("same-origin", "none"):
        return False
    origin = headers.get("origin")
    if origin is None or origin in allowed_origins:
        return True
    if origin == "null":
        return site is not None
    return urlsplit(origin).netloc == headers.get("host")


class Guard:
    """The outermost layer of the app."""

    def __init__(
        self, app: ASGIApp, error_page: ErrorPage, allowed_origins: tuple[str, ...] = ()
    ) -> None:
        self._app = app
        self._error_page = error_page
        self._allowed_origins = allowed_origins

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request; sockets check their origin themselves when they accept."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        answer = _Answer(scope, send)
        try:
            self._check(Headers(scope=scope), scope["method"])
            await self._app(scope, _limit(receive), answer.send)
        except Exception as error:
            if answer.started:
                raise
            request = Request(scope, receive)
            reference = ""
            if not isinstance(error, StudyError):
                reference = secrets.token_hex(4)
                log.exception("unexpected error, reference %s", reference)
            page = await self._error_page(request, error, reference)
            await page(scope, receive, answer.send)

    def _check(self, headers: Headers, method: str) -> None:
        if method not in SAFE_METHODS and not same_origin(headers, self._allowed_origins):
            raise ForeignOrigin
        length = headers.get("content-length", "0")
        if not (length.isascii() and length.isdigit()) or int(length[:12]) > BODY_LIMIT_BYTES:
            raise TooLarge(BODY_LIMIT_BYTES)


class _Answer:
    """Adds the headers to an answer and remembers that it began."""

    def __init__(self, scope: Scope, send: Send) -> None:
        self.started = False
        self._static = scope["path"].startswith("/static/")
        self._send = send

    async def send(self, message: Message) -> None:
        if message["type"] == "http.response.start":
            self.started = True
            headers = MutableHeaders(scope=message)
            for name, value in HEADERS.items():
                headers[name] = value
            if not self._static or message["status"] >= 400:
                headers["Cache-Control"] = "no-store"
        await self._send(message)


def _limit(receive: Receive) -> Receive:
    """Count a body that came without a length, or with a wrong one."""
    seen = 0

    async def counted() -> Message:
        nonlocal seen
        message = await receive()
        if message["type"] == "http.request":
            seen += len(message.get("body", b""))
            if seen > BODY_LIMIT_BYTES:
                raise TooLarge(BODY_LIMIT_BYTES)
        return message

    return counted
