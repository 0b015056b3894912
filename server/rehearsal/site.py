"""A running server as a program reaches it: pages, forms and JSON over HTTP, nothing cached.

Requests run in threads, each on a connection of its own.
"""

from __future__ import annotations

import asyncio
import http.client
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import urlencode, urlsplit

from study.errors import InvalidValue, StudyError

TIMEOUT_S = 60.0
PIECE_BYTES = 1 << 20
_FORM = {"Content-Type": "application/x-www-form-urlencoded"}
_JSON = {"Content-Type": "application/json"}


class SiteError(StudyError):
    """The server answered otherwise than it should, or not at all."""


@dataclass(frozen=True)
class Reply:
    """A server's answer; `location` is where it leads, empty if nowhere."""

    status: int
    text: str
    location: str = ""
    cookie: str = ""


@dataclass
class Site:
    """The server at one address. `cookie` is staff's sign-in; participants have none."""

    url: str
    cookie: str = field(default="", repr=False)

    def __post_init__(self) -> None:
        parts = urlsplit(self.url)
        if parts.scheme not in ("http", "https") or not parts.hostname:
            raise InvalidValue(
                f"“{self.url[:80]}” is no address of a server",
                next_step="Give it as http://127.0.0.1:8000.",
            )
        self._parts = parts

    @property
    def socket_url(self) -> str:
        """Where sockets are opened, without a path."""
        scheme = "wss" if self._parts.scheme == "https" else "ws"
        return f"{scheme}://{self._parts.netloc}{self._parts.path.rstrip('/')}"

    async def get(self, path: str) -> Reply:
        """A page, redirects not followed."""
        return await asyncio.to_thread(self._ask, "GET", path, None, {})

    async def send_form(self, path: str, form: Mapping[str, str]) -> Reply:
        """Send a form."""
        return await asyncio.to_thread(self._ask, "POST", path, urlencode(form), _FORM)

    async def read_json(self, path: str) -> Any:
        """What the interface for programs answers; raises `SiteError` with its reason."""
        return _read_answer(path, await self.get(path))

    async def send_json(self, path: str, body: Any) -> Any:
        """Ask the interface for programs to do something; raises `SiteError` with its reason."""
        reply = await asyncio.to_thread(self._ask, "POST", path, json.dumps(body), _JSON)
        return _read_answer(path, reply)

    async def sign_in(self, name: str, password: str) -> None:
        """Sign in as staff; raises `SiteError` if the server refuses."""
        reply = await self.send_form("/login", {"name": name, "password": password})
        if reply.status != 303 or not reply.cookie:
            raise SiteError(
                f"{self.url} does not let “{name}” sign in (status {reply.status})",
                next_step="Check VARIL_ADMIN_PASSWORD or --password-file, and --user.",
            )
        self.cookie = reply.cookie

    async def download(self, path: str, file: Path) -> None:
        """Save what is at an address; raises `SiteError` if it breaks off."""
        await asyncio.to_thread(self._download, path, file)

    def _ask(self, method: str, path: str, body: str | None, headers: Mapping[str, str]) -> Reply:
        link = self._connect()
        try:
            address = self._parts.path.rstrip("/") + path
            link.request(method, address, body, self._own | dict(headers))
            answer = link.getresponse()
            text = answer.read().decode("utf-8", "replace")
        except (OSError, http.client.HTTPException) as error:
            raise self._away(error) from error
        finally:
            link.close()
        cookie = (answer.getheader("set-cookie") or "").partition(";")[0]
        return Reply(answer.status, text, answer.getheader("location") or "", cookie)

    def _download(self, path: str, file: Path) -> None:
        link = self._connect()
        try:
            link.request("GET", self._parts.path.rstrip("/") + path, headers=dict(self._own))
            answer = link.getresponse()
            if answer.status != 200:
                _read_answer(path, Reply(answer.status, answer.read().decode("utf-8", "replace")))
            with file.open("wb") as out:
                while piece := answer.read(PIECE_BYTES):
                    out.write(piece)
        except (OSError, http.client.HTTPException) as error:
            raise self._away(error) from error
        finally:
            link.close()

    @property
    def _own(self) -> dict[str, str]:
        return {"Cookie": self.cookie} if self.cookie else {}

    def _connect(self) -> http.client.HTTPConnection:
        secure = self._parts.scheme == "https"
        kind = http.client.HTTPSConnection if secure else http.client.HTTPConnection
        return kind(str(self._parts.hostname), self._parts.port, timeout=TIMEOUT_S)

    def _away(self, error: Exception) -> SiteError:
        return SiteError(
            f"{self.url} does not answer ({str(error) or type(error).__name__})",
            next_step="Check that the server runs and that --url is its address.",
        )


def _read_answer(path: str, reply: Reply) -> Any:
    try:
        body = json.loads(reply.text)
    except ValueError:
        body = {}
    if reply.status >= 400 or not isinstance(body, dict | list):
        what = body.get("detail", "no reason given") if isinstance(body, dict) else ""
        next_step = body.get("next_step", "") if isinstance(body, dict) else ""
        raise SiteError(f"{path} answered {reply.status}: {what}", next_step=str(next_step))
    return body
