"""Guards what a killed server and a lost database leave behind: all that was told is stored."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.postgres import PostgresServer, find_programs, free_port
from tests.reliability.drill import killing, losing, run_drill
from tests.reliability.server_process import ServerProcess, write_study


async def test_a_killed_server_loses_nothing_it_told(tmp_path: Path) -> None:
    """Two take part while the server is killed twice; nobody meets a dead end."""
    study = write_study(tmp_path, "practice")
    server = ServerProcess(tmp_path, free_port(), study)
    found = await run_drill(server, killing(server), people=2, outages=2, seed=1)
    assert found.is_well, found.to_json()
    assert (found.outages, found.trials >= 6) == (2, True)
    assert found.hashes_checked > 100


@pytest.mark.postgres
async def test_a_database_that_goes_away_takes_nothing_with_it(tmp_path: Path) -> None:
    """PostgreSQL is stopped for two seconds; play goes on, and everything is stored later."""
    programs = find_programs()
    assert programs is not None
    with PostgresServer(programs) as postgres:
        url = f"{postgres.url}/postgres"
        server = ServerProcess(tmp_path, free_port(), write_study(tmp_path, "practice"), url)
        server.migrate()
        outage = losing(postgres, server, 2.0)
        found = await run_drill(server, outage, people=2, outages=1, seed=2)
    assert found.is_well, found.to_json()
    assert (found.outages, found.trials >= 6) == (1, True)
