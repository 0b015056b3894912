"""Guards that an export's memory does not grow with the study, and that downloads are apart."""

from __future__ import annotations

import asyncio
import io
import os
import zipfile

import pytest

from server.bench.export import measure_export
from server.export.bundle import ExportOptions
from server.export.process import ExportFailed, begin_export
from server.settings import Settings
from server.store.bench_people import add_bench_people
from server.store.engine import Database, StorageAway
from server.store.schema import migrate
from study.config import Study


@pytest.fixture
async def served(settings: Settings, study: Study) -> Settings:
    """Settings of a server with a few participants."""
    database = Database(settings.database)
    await migrate(database)
    await add_bench_people(database, study, 20)
    await database.close()
    return settings


def test_memory_does_not_grow_with_the_study() -> None:
    """`varil bench export` measures 1000 participants; a tenth of the growth would show here."""
    few, many = measure_export(4), measure_export(48)
    assert (many["rows"]["trials"], many["rows"]["events"]) == (144, 144 * 564)
    assert many["peak_mb"] < 300
    assert many["peak_mb"] - few["peak_mb"] < 20


async def test_a_download_is_a_whole_zip(served: Settings) -> None:
    pieces = await begin_export(served, ExportOptions("demo", mode="bot"))
    data = b"".join([piece async for piece in pieces])
    with zipfile.ZipFile(io.BytesIO(data)) as bundle:
        assert bundle.testzip() is None
        assert bundle.read("trials.csv").count(b"\n") == 61


async def test_whoever_stops_reading_ends_the_process(
    served: Settings, monkeypatch: pytest.MonkeyPatch
) -> None:
    endless = "import os, sys\nwhile True: sys.stdout.write(str(os.getpid()).ljust(65536))"
    monkeypatch.setattr("server.export.process._COMMAND", endless)
    pieces = await begin_export(served, ExportOptions("demo"))
    process_id = int((await anext(pieces)).split()[0])
    os.kill(process_id, 0)
    await pieces.aclose()
    with pytest.raises(ProcessLookupError):
        os.kill(process_id, 0)


async def test_a_failed_start_is_told_and_a_failed_end_cuts_the_download(
    served: Settings, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(StorageAway):
        await begin_export(served, ExportOptions("nobody-knows-it"))
    broken = "import sys; sys.stdout.write('PK'); sys.stdout.flush(); sys.exit(3)"
    monkeypatch.setattr("server.export.process._COMMAND", broken)
    pieces = await begin_export(served, ExportOptions("demo"))
    with pytest.raises(ExportFailed):
        async with asyncio.timeout(20):
            assert [piece async for piece in pieces]
