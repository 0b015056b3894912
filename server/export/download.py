"""An export as the answer to a request: noted in the audit, made by a process of its own."""

from __future__ import annotations

from datetime import UTC, datetime

from starlette.responses import StreamingResponse

from server.desks.audit import AuditDesk
from server.export.bundle import ExportOptions
from server.export.process import begin_export
from server.settings import Settings


async def answer_download(
    settings: Settings, audit: AuditDesk, options: ExportOptions, user_name: str
) -> StreamingResponse:
    """The zip, sent while it is written. Raises `StorageAway` if it cannot be begun."""
    parts = [options.study_id, options.mode or "all modes"]
    parts += ["with telemetry"] if options.telemetry else []
    parts += ["with panel ids"] if options.panel_ids else []
    await audit.note(user_name, "export downloaded", ", ".join(parts))
    pieces = await begin_export(settings, options)
    made = f"{datetime.now(UTC):%Y%m%dT%H%M%SZ}"
    name = f"{options.study_id}-{options.mode or 'all'}-{made}.zip"
    return StreamingResponse(
        pieces,
        media_type="application/zip",
        headers={"Content-Disposition": f'attachment; filename="{name}"'},
    )
