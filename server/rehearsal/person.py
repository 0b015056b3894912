"""One simulated participant from the personal address to the last page.

What it does besides taking part is decided beforehand, by seed: it leaves for good, withdraws,
loads pages again, or answers late and sends an old form once more.
"""

from __future__ import annotations

import asyncio
import random
import time
from dataclasses import dataclass, field
from typing import Literal

from server.rehearsal.forms import PageReader, fill_in, mend
from server.rehearsal.player import Halls, Player
from server.rehearsal.site import Reply, Site, SiteError

Fate = Literal["stays", "drops", "withdraws"]
RELOAD_SHARE = 0.3
LATE_S = 0.5
MOST_PAGES = 500
MOST_MENDS = 4


@dataclass(frozen=True)
class Role:
    """What one participant will do. `leaves_at`: the share of the study after which it leaves."""

    fate: Fate
    leaves_at: float
    reloads: bool
    is_late: bool


@dataclass
class Story:
    """What became of it; `times` are seconds by step, one entry for each time it was done."""

    code: str
    role: Role
    end: Literal["", "completed", "ended", "dropped", "withdrew"] = ""
    errors: list[str] = field(default_factory=list)
    times: list[tuple[str, float]] = field(default_factory=list)


class Person:
    """Walks through the pages of one address."""

    def __init__(
        self, site: Site, address: str, story: Story, draws: random.Random, halls: Halls
    ) -> None:
        self._site = Site(site.url)  # no sign-in: a participant has none
        self._address = address
        self._story = story
        self._draws = draws
        self._halls = halls
        self._share = 0.0
        self._old: tuple[str, dict[str, str]] | None = None

    async def take_part(self) -> None:
        """Go on until the end, or until it leaves; faults are noted in the story."""
        try:
            for _ in range(MOST_PAGES):
                if await self._do_page():
                    return
            self._complain("the study does not come to an end")
        except SiteError as error:
            self._complain(error.what)

    async def _do_page(self) -> bool:
        """One page; True when there is nothing more to do."""
        role, story = self._story.role, self._story
        page = await self._open()
        if page.live:
            return await self._play(page)
        self._share = page.share_done if page.share_done is not None else self._share
        if not page.action:
            story.end = "completed" if page.has_code and self._share == 1.0 else "ended"
            return True
        if role.fate != "stays" and self._share >= role.leaves_at:
            await self._leave()
            return True
        if role.is_late:
            await self._dawdle()
        await self._send(page)
        return False

    async def _open(self) -> PageReader:
        reply = await self._site.get(self._address)
        if self._story.role.reloads and self._draws.random() < RELOAD_SHARE:
            again = await self._site.get(self._address)
            if again.text != reply.text:
                self._complain("a page that was loaded again was another one")
        _require(reply, 200, "the personal address")
        return PageReader(reply.text)

    async def _send(self, page: PageReader) -> None:
        began_s = time.perf_counter()
        step, form = page.step, fill_in(page, self._draws)
        reply = await self._site.send_form(page.action, form)
        for _ in range(MOST_MENDS):
            if reply.status != 422:
                break
            form = mend(form, PageReader(reply.text), self._draws)
            reply = await self._site.send_form(page.action, form)
        _require(reply, 303, f"the form of {step}")
        self._old = (page.action, form)
        self._story.times.append((step, time.perf_counter() - began_s))

    async def _play(self, page: PageReader) -> bool:
        """The trial of this page; True if the participant left in the middle of it."""
        role, began_s = self._story.role, time.perf_counter()
        player = Player(self._site, page.live, self._draws, self._halls)
        left_at = 0
        if role.fate != "stays" and self._share >= role.leaves_at - 0.1:
            await player.play(self._draws.randrange(30, 600))
            await self._leave()
            return True
        if role.reloads:
            left = await player.play(self._draws.randrange(30, 600))
            left_at = 0 if left.next else left.ticks
            if left.next:
                return False
        await player.play(from_tick=left_at)
        self._story.times.append(("play", time.perf_counter() - began_s))
        return False

    async def _leave(self) -> None:
        if self._story.role.fate == "drops":
            self._story.end = "dropped"
            return
        _require(await self._site.get(f"{self._address}/withdraw"), 200, "the page to withdraw")
        reply = await self._site.send_form(f"{self._address}/withdraw", {})
        _require(reply, 303, "withdrawing")
        self._story.end = "withdrew"

    async def _dawdle(self) -> None:
        """Wait, then send the last form once more: it is welcome and changes nothing."""
        await asyncio.sleep(LATE_S * self._draws.random())
        if self._old is not None:
            action, form = self._old
            reply = await self._site.send_form(action, form)
            if reply.status not in (303, 409):
                self._complain(f"an old form sent again was answered {reply.status}")

    def _complain(self, what: str) -> None:
        self._story.errors.append(f"{self._story.code}: {what}")


def _require(reply: Reply, status: int, what: str) -> None:
    if reply.status != status:
        raise SiteError(f"{what} was answered {reply.status} instead of {status}")
