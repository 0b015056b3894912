"""The drill: the server is killed, or its database is taken away, while people take part.

Simulated participants take part in lock-step. When all have come to the last page, what they were
told is held against what is stored: every form that was taken, how far back each trial went, every
state hash.
"""

from __future__ import annotations

import asyncio
import csv
import io
import random
import signal
import time
import zipfile
from collections.abc import Awaitable, Callable
from dataclasses import asdict, dataclass, field
from typing import Any

from server.export.bundle import ExportOptions, write_export
from server.rehearsal.player import Halls
from server.rehearsal.site import Site
from server.replay.run import NothingPlayed, load_trial, replay_trial
from server.settings import Settings
from study.records.cells import neutralise_formula
from tests.postgres import PostgresServer
from tests.reliability.server_process import PASSWORD, ServerProcess
from tests.reliability.stubborn import Outages, StubbornPerson

LEAST_GAP_S, MOST_GAP_S = 0.5, 4.0
BACK_S = 1.0
COMMIT_S = 0.5
"""A batch is stored once a second; what was under way when the server fell took a moment more."""


@dataclass
class Findings:
    """What the drill found; only `returns_s` may hold something above 0 when all is well."""

    people: int = 0
    outages: int = 0
    wall_s: float = 0.0
    unfinished: list[str] = field(default_factory=list)
    errors: list[str] = field(default_factory=list)
    forms_taken: int = 0
    answers_lost: list[str] = field(default_factory=list)
    returns_s: list[float] = field(default_factory=list)
    trials: int = 0
    hashes_checked: int = 0
    mismatches: int = 0

    @property
    def is_well(self) -> bool:
        """Whether nothing was lost, and nobody was stopped."""
        lost = self.unfinished or self.errors or self.answers_lost or self.mismatches
        return not lost and max(self.returns_s, default=0.0) <= BACK_S + COMMIT_S

    def to_json(self) -> dict[str, Any]:
        """Everything that was found."""
        longest_s = round(max(self.returns_s, default=0.0), 2)
        told = asdict(self) | {"returns": len(self.returns_s), "longest_return_s": longest_s}
        del told["returns_s"]
        return told | {"is_well": self.is_well}


Outage = Callable[[], Awaitable[None]]


def killing(server: ServerProcess) -> Outage:
    """`kill -9`, and a new process at once."""

    async def kill() -> None:
        await asyncio.to_thread(server.end, signal.SIGKILL)
        server.start()
        await server.wait_until("/readyz", 200)

    return kill


def losing(postgres: PostgresServer, server: ServerProcess, away_s: float) -> Outage:
    """The database goes away for so long; `/readyz` must say so, and later that it is back."""

    async def lose() -> None:
        await asyncio.to_thread(postgres.stop)
        began_s = time.monotonic()
        await server.wait_until("/readyz", 503)
        await server.wait_until("/healthz", 200)
        await asyncio.sleep(max(0.0, away_s - (time.monotonic() - began_s)))
        await asyncio.to_thread(postgres.start)
        await server.wait_until("/readyz", 200)

    return lose


async def run_drill(
    server: ServerProcess, outage: Outage, people: int, outages: int, seed: int
) -> Findings:
    """Let people take part while outages happen at random moments, then look at what is stored."""
    began_s, draws, record = time.monotonic(), random.Random(seed), Outages()
    server.start()
    try:
        await server.wait_until("/readyz", 200)
        site = Site(server.url)
        await site.sign_in("admin", PASSWORD)
        issued = (await site.send_json("/api/v1/studies/drill/bots", {"count": people}))["bots"]
        halls = Halls()
        cast = [
            StubbornPerson(
                server.url, bot["address"], bot["code"], random.Random(f"{seed} {n}"), halls, record
            )
            for n, bot in enumerate(issued)
        ]
        taking_part = asyncio.gather(*(person.take_part() for person in cast))
        await _have_outages(outage, outages, draws, record, taking_part)
        await taking_part
    finally:
        await asyncio.to_thread(server.end, signal.SIGINT)
    found = Findings(people=people, outages=len(record.began_s))
    for person in cast:
        found.errors += person.story.errors
        found.returns_s += person.kept.returns_s
        if person.story.end != "completed":
            found.unfinished.append(person.story.code)
    await _look_at_answers(server.settings, cast, found)
    await _look_at_trials(server.settings, found)
    found.wall_s = round(time.monotonic() - began_s, 1)
    return found


async def _have_outages(
    outage: Outage,
    outages: int,
    draws: random.Random,
    record: Outages,
    taking_part: asyncio.Future[list[None]],
) -> None:
    for _ in range(outages):
        gap_s = draws.uniform(LEAST_GAP_S, MOST_GAP_S)
        await asyncio.wait([taking_part], timeout=gap_s)
        if taking_part.done():
            return
        record.began_s.append(time.monotonic())
        record.is_away = True
        await outage()
        record.is_away = False


async def _look_at_answers(settings: Settings, cast: list[StubbornPerson], found: Findings) -> None:
    """Every answer in a form that was taken is in responses.csv as it was given."""
    rows = await _export(settings, "responses.csv")
    stored = {(r["participant_code"], r["step"], r["item"]): r["value"] for r in rows}
    asked = {(step, item) for _, step, item in stored}
    for person in cast:
        for step, form in person.kept.forms:
            found.forms_taken += 1
            for item, given in form.items():
                kept = stored.get((person.story.code, step, item))
                if (step, item) in asked and kept != neutralise_formula(given.strip()):
                    found.answers_lost.append(
                        f"{person.story.code} {step} {item}: {given!r} was kept as {kept!r}"
                    )


async def _look_at_trials(settings: Settings, found: Findings) -> None:
    """Every trial that was played simulates to the states that were stored."""
    for row in await _export(settings, "trials.csv"):
        try:
            summary = replay_trial(await load_trial(settings, row["trial_id"]), None, None)
        except NothingPlayed:
            continue
        found.trials += 1
        found.hashes_checked += summary["hashes_checked"]
        found.mismatches += summary["mismatches"]


async def _export(settings: Settings, table: str) -> list[dict[str, str]]:
    file = settings.var_dir / "drill.zip"
    await write_export(settings, ExportOptions("drill", "bot", False, False), file)
    with zipfile.ZipFile(file) as bundle:
        return list(csv.DictReader(io.StringIO(bundle.read(table).decode(), newline="")))
