"""What it takes to export a large study: time and memory of the command in its own process."""

from __future__ import annotations

import asyncio
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from server.store.bench_people import add_bench_people
from server.store.engine import Database
from server.store.schema import migrate
from study.files.demo import paper_study

_CHILD = """
import pathlib, resource, sys
from server.cli.main import app, run_command
code = run_command(lambda **options: app(sys.argv[1:], **options))
status = pathlib.Path("/proc/self/status")  # getrusage would count the parent's memory, too
lines = status.read_text().splitlines() if status.exists() else []
peaks = [int(line.split()[1]) for line in lines if line.startswith("VmHWM:")]
print(peaks[0] if peaks else resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
sys.exit(code)
"""


def measure_export(people: int) -> dict[str, Any]:
    """Seconds, peak memory and size for so many participants with three trials each."""
    with tempfile.TemporaryDirectory(prefix="varil-bench-") as folder:
        url = f"sqlite:///{folder}/bench.sqlite3"
        asyncio.run(_fill(url, people))
        out = Path(folder) / "out.zip"
        words = ["export", "--study", "demo", "--out", str(out), "--json"]
        started_s = time.perf_counter()
        done = subprocess.run(
            [sys.executable, "-c", _CHILD, *words],
            env={**os.environ, "VARIL_DATABASE_URL": url},
            capture_output=True,
            text=True,
            check=True,
        )
        wall_s = time.perf_counter() - started_s
        *_, counts, peak_kb = done.stdout.strip().splitlines()
        rows = json.loads(counts)
        del rows["file"]
        return {
            "participants": people,
            "peak_mb": round(int(peak_kb) / 1024, 1),
            "wall_s": round(wall_s, 1),
            "zip_mb": round(out.stat().st_size / 1e6, 1),
            "rows": rows,
        }


async def _fill(url: str, people: int) -> None:
    database = Database(url)
    await migrate(database)
    await add_bench_people(database, paper_study(), people)
    await database.close()
