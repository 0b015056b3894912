"""Templates and static files: one renderer that knows the built assets and their hashes."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from datetime import datetime
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup
from starlette.requests import Request
from starlette.responses import HTMLResponse, Response
from starlette.staticfiles import StaticFiles
from starlette.types import Scope

from server.pages.markdown import render_line, render_markdown
from study.errors import StudyError

_BUNDLES = (
    "page.css", "play.css", "expert.css", "play.js", "check.js", "form.js", "expert.js",
    "staff.js", "watch.js",
)  # fmt: skip


class MissingAssets(StudyError):
    """The browser client was not built."""

    def __init__(self, missing: list[str]) -> None:
        self.missing = missing
        super().__init__(
            f"the browser client is not built ({', '.join(missing)} missing)",
            next_step="Run `make install`.",
        )


class Assets:
    """Addresses of static files that change with their contents."""

    def __init__(self, static: Path) -> None:
        self._static = static
        self._seen: dict[str, tuple[float, str]] = {}

    def check(self) -> None:
        """Raise `MissingAssets` unless everything that pages load was built."""
        missing = [name for name in _BUNDLES if not (self._static / "dist" / name).is_file()]
        if missing:
            raise MissingAssets(missing)

    def address(self, name: str) -> str:
        """`/static/<name>?v=<hash>`; the hash is taken anew when the file changes."""
        file = self._static / name
        try:
            changed = file.stat().st_mtime
        except FileNotFoundError:
            return f"/static/{name}"
        if self._seen.get(name, (0.0, ""))[0] != changed:
            digest = hashlib.sha256(file.read_bytes()).hexdigest()[:12]
            self._seen[name] = (changed, digest)
        return f"/static/{name}?v={self._seen[name][1]}"


class Renderer:
    """Turns a template and its values into a page."""

    def __init__(self, web: Path) -> None:
        self.assets = Assets(web / "static")
        self._environment = Environment(
            loader=FileSystemLoader(web / "templates"),
            autoescape=True,
            undefined=StrictUndefined,
            trim_blocks=True,
            lstrip_blocks=True,
        )
        self._environment.globals["asset"] = self.assets.address
        self._environment.filters |= {
            "markdown": render_markdown,
            "line": render_line,
            "when": time_element,
        }

    def page(self, template: str, values: Mapping[str, Any], status: int = 200) -> HTMLResponse:
        """The page as an answer."""
        return HTMLResponse(self._environment.get_template(template).render(values), status)


def moment(at: datetime | None) -> str:
    """A moment in UTC as tables show it; nothing for none."""
    return f"{at:%Y-%m-%d %H:%M:%S}" if at else ""


def time_element(at: datetime | None) -> Markup:
    """A moment for staff: in UTC until the page's code turns it into the viewer's own time."""
    if at is None:
        return Markup()
    machine, human = f"{at:%Y-%m-%dT%H:%M:%S}Z", moment(at)
    return Markup('<time datetime="{}" title="{} UTC">{}</time>').format(machine, human, human)


class CachedFiles(StaticFiles):
    """Static files; those asked for with their hash may be kept for a year."""

    async def get_response(self, path: str, scope: Scope) -> Response:
        """Serve one file."""
        response = await super().get_response(path, scope)
        hashed = "v" in Request(scope).query_params or Path(path).name.startswith("chunk-")
        lasting = hashed and response.status_code == 200
        response.headers["Cache-Control"] = (
            "public, max-age=31536000, immutable" if lasting else "no-cache"
        )
        return response
