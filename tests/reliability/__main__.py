"""Hold a drill and print what was found as JSON; exit code 1 if anything was lost.

    python -m tests.reliability [--people 20] [--outages 20] [--seed 1] [--hall small]
    python -m tests.reliability --database-away-s 30 --outages 1

By default the server is killed at random moments; with `--database-away-s` a PostgreSQL server is
stopped for so long instead.
"""

from __future__ import annotations

import asyncio
import json
import tempfile
from pathlib import Path

import typer

from server.kernel_cache import open_kernel_cache
from tests.postgres import PostgresServer, find_programs, free_port
from tests.reliability.drill import killing, losing, run_drill
from tests.reliability.server_process import ServerProcess, write_study


def command(
    people: int = 20,
    outages: int = 20,
    seed: int = 1,
    hall: str = "small",
    database_away_s: float = 0.0,
) -> None:
    """Hold a drill and print what was found."""
    open_kernel_cache()
    with tempfile.TemporaryDirectory(prefix="varil-drill-") as name:
        folder = Path(name)
        study = write_study(folder, hall)
        if database_away_s:
            programs = find_programs()
            assert programs is not None, "PostgreSQL's server programs are not installed"
            with PostgresServer(programs) as postgres:
                server = ServerProcess(folder, free_port(), study, f"{postgres.url}/postgres")
                server.migrate()
                outage = losing(postgres, server, database_away_s)
                found = asyncio.run(run_drill(server, outage, people, outages, seed))
        else:
            server = ServerProcess(folder, free_port(), study)
            found = asyncio.run(run_drill(server, killing(server), people, outages, seed))
    typer.echo(json.dumps(found.to_json()))
    raise typer.Exit(0 if found.is_well else 1)


if __name__ == "__main__":
    typer.run(command)
