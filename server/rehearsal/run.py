"""A whole rehearsal: issue, take part, export, analyse, and say whether the study can be launched.

Those who will leave go first, with half of the others. Their places are given back, and the rest
must fill them: so the balance of the cells is tried as well.
"""

from __future__ import annotations

import asyncio
import random
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from server.rehearsal.checks import Check, Evidence, check_rehearsal
from server.rehearsal.person import Fate, Person, Role, Story
from server.rehearsal.player import Halls
from server.rehearsal.site import Site
from study.errors import InvalidValue, StudyError

AT_ONCE = 8
ZIP, REPORT = "rehearsal.zip", "report"
Tell = Callable[[str], None]


@dataclass(frozen=True)
class RehearsalOptions:
    """What was asked for. The shares are of all participants; those who leave do so once.

    `study_id` is empty for the only study of the server.
    """

    url: str
    participants: int
    seed: int
    out: Path
    study_id: str = ""
    dropout: float = 0.1
    withdraw: float = 0.05
    reload: float = 0.2
    late: float = 0.2

    def __post_init__(self) -> None:
        if self.dropout + self.withdraw > 1.0:
            raise InvalidValue(
                f"{self.dropout:g} drop out and {self.withdraw:g} withdraw: more than there are",
                next_step="Give shares that come to 1 at most.",
            )


@dataclass(frozen=True)
class Outcome:
    """How the rehearsal went."""

    stories: Sequence[Story]
    checks: Sequence[Check]
    wall_s: float
    problems: Sequence[str]

    @property
    def is_green(self) -> bool:
        """Whether nothing speaks against a launch."""
        return all(check.passed for check in self.checks)

    def to_json(self) -> dict[str, Any]:
        """The summary."""
        ends = [story.end for story in self.stories]
        return {
            "participants": len(self.stories),
            "completed": ends.count("completed"),
            "dropped": ends.count("dropped") + ends.count("withdrew"),
            "wall_s": round(self.wall_s, 2),
            "errors": len(self.problems),
            "withdrew": ends.count("withdrew"),
            "green": self.is_green,
            "checks": [vars(check) for check in self.checks],
            "problems": list(self.problems),
        }


def cast_roles(options: RehearsalOptions) -> list[Role]:
    """What each participant will do, drawn by seed; those who leave first."""
    draws = random.Random(f"roles {options.seed}")  # noqa: S311 - nothing secret
    n = options.participants
    drops = round(n * options.dropout)
    leaves: list[Fate] = ["drops"] * drops
    leaves += ["withdraws"] * min(n - drops, round(n * options.withdraw))
    fates: list[Fate] = leaves + ["stays"] * (n - len(leaves))
    reloads, late = _choose(n, options.reload, draws), _choose(n, options.late, draws)
    return [
        Role(fate, draws.uniform(0.1, 0.85), k in reloads, k in late)
        for k, fate in enumerate(fates)
    ]


async def rehearse(options: RehearsalOptions, site: Site, tell: Tell) -> Outcome:
    """Rehearse on a server where `site` is signed in; results go to the folder `out`.

    Raises StudyError if the server cannot be used at all; what goes wrong later is in the outcome.
    """
    began_s = time.perf_counter()
    options = replace(options, study_id=await find_study(site, options.study_id))
    study = await site.read_json(f"/api/v1/studies/{options.study_id}")
    await asyncio.to_thread(options.out.mkdir, parents=True, exist_ok=True)
    stories = await _take_part(options, site, tell)
    problems = [error for story in stories for error in story.errors]
    tell("Export and analysis ...")
    file, report = options.out / ZIP, options.out / REPORT
    export = f"/api/v1/studies/{options.study_id}/export?mode=bot"
    try:
        await site.download(export, file)
        await asyncio.to_thread(_analyse, file, report)
    except (StudyError, OSError) as error:
        problems.append(error.sentence if isinstance(error, StudyError) else str(error))
    evidence = Evidence(study, stories, tuple(problems), file, report)
    checks = await asyncio.to_thread(check_rehearsal, evidence)
    return Outcome(stories, checks, time.perf_counter() - began_s, problems)


async def find_study(site: Site, wanted: str) -> str:
    """The study to rehearse; raises InvalidValue naming those there are if it is not clear."""
    known = [str(study["study_id"]) for study in await site.read_json("/api/v1/studies")]
    if wanted in known or (not wanted and len(known) == 1):
        return wanted or known[0]
    if not known:
        raise InvalidValue(
            f"{site.url} has no study",
            next_step="Start the server with one: varil serve --study FILE.",
        )
    what = f"has no study “{wanted[:40]}”" if wanted else "has several studies"
    raise InvalidValue(
        f"{site.url} {what}", next_step=f"Name one with --study: {', '.join(known)}."
    )


async def _take_part(options: RehearsalOptions, site: Site, tell: Tell) -> list[Story]:
    roles = cast_roles(options)
    leavers = sum(role.fate != "stays" for role in roles)
    first = leavers + (len(roles) - leavers) // 2 if leavers else len(roles)
    halls = Halls()
    stories: list[Story] = []
    bots = f"/api/v1/studies/{options.study_id}/bots"
    for wave in (roles[:first], roles[first:]):
        if not wave:
            continue
        issued = (await site.send_json(bots, {"count": len(wave)}))["bots"]
        told = [Story(bot["code"], role) for bot, role in zip(issued, wave, strict=True)]
        people = [
            Person(site, bot["address"], story, _draws(options.seed, len(stories) + n), halls)
            for n, (bot, story) in enumerate(zip(issued, told, strict=True))
        ]
        tell(f"Participants {len(stories) + 1} to {len(stories) + len(wave)} of {len(roles)} ...")
        stories += told
        seats = asyncio.Semaphore(AT_ONCE)
        await asyncio.gather(*(_seat(person, seats) for person in people))
        dropped = [story.code for story in told if story.end == "dropped"]
        if dropped:
            await site.send_json(f"{bots}/time-out", {"codes": dropped})
    return stories


async def _seat(person: Person, seats: asyncio.Semaphore) -> None:
    async with seats:
        await person.take_part()


def _choose(n: int, share: float, draws: random.Random) -> set[int]:
    return set(draws.sample(range(n), round(n * share)))


def _draws(seed: int, number: int) -> random.Random:
    return random.Random(f"participant {seed} {number}")  # noqa: S311 - nothing secret


def _analyse(file: Path, report: Path) -> None:
    from server.analysis.run import AnalysisOptions, analyze

    analyze(AnalysisOptions(file, report, "bot"))
