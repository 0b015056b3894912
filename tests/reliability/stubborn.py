"""Participants who stay when the server goes, as a browser does: they wait and load the page again.

What they were told is kept, to be held against what is stored: each form that was taken, and each
moment of a trial that they saw.
"""

from __future__ import annotations

import asyncio
import random
import time
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from server.rehearsal.forms import PageReader
from server.rehearsal.person import Person, Role, Story
from server.rehearsal.player import Halls, Player
from server.rehearsal.site import Reply, Site, SiteError

STEADY = Role("stays", 1.0, reloads=False, is_late=False)
LOOK_EVERY_S = 0.05
AWAY = (502, 503)


@dataclass
class Outages:
    """When the server was taken away: a fault that meets an outage is no fault of the server."""

    began_s: list[float] = field(default_factory=list)
    is_away: bool = False

    def excuse(self, since_s: float) -> bool:
        """Whether there was an outage at any time since then."""
        return self.is_away or any(moment >= since_s for moment in self.began_s)


@dataclass
class Kept:
    """What one participant was told: forms taken, and how far each return to a trial went back."""

    forms: list[tuple[str, Mapping[str, str]]] = field(default_factory=list)
    returns_s: list[float] = field(default_factory=list)


class RecordingSite(Site):
    """Remembers every form that the server said it took."""

    kept: Kept

    async def send_form(self, path: str, form: Mapping[str, str]) -> Reply:
        """Send a form; a server without its storage asks to try again, and that is done."""
        reply = await super().send_form(path, form)
        if reply.status in AWAY:
            raise SiteError("the storage is away")
        if reply.status == 303:
            self.kept.forms.append((path.rsplit("/", 1)[-1], dict(form)))
        return reply

    async def get(self, path: str) -> Reply:
        """A page; one that says that the storage is away is tried again."""
        reply = await super().get(path)
        if reply.status in AWAY:
            raise SiteError("the storage is away")
        return reply


class StubbornPerson(Person):
    """Takes part to the end, whatever happens to the server meanwhile."""

    def __init__(
        self, url: str, address: str, code: str, draws: random.Random, halls: Halls, out: Outages
    ) -> None:
        story = Story(code, STEADY)
        super().__init__(Site(url), address, story, draws, halls)
        self.story, self.kept, self._outages = story, Kept(), out
        self._site = RecordingSite(url)
        self._site.kept = self.kept
        self._seen: deque[tuple[float, int]] = deque(maxlen=4000)

    async def take_part(self) -> None:
        """Until the last page; an error without an outage is noted and ends it."""
        while not self.story.end:
            began_s = time.monotonic()
            try:
                await self._do_page()
            except SiteError as error:
                if not self._outages.excuse(began_s):
                    self._complain(error.what)
                    return
                await asyncio.sleep(LOOK_EVERY_S)

    async def _play(self, page: PageReader) -> bool:
        """The trial of this page from wherever the server goes on with it."""
        player, before = Player(self._site, page.live, self._draws, self._halls), [*self._seen]
        self._seen.clear()
        watching = asyncio.create_task(self._watch(player))
        try:
            await player.play(from_tick=None)
        finally:
            watching.cancel()
            self._look(player)
            self._note_return(before, player.began_at)
        self._seen.clear()
        return False

    async def _watch(self, player: Player) -> None:
        while True:
            await asyncio.sleep(LOOK_EVERY_S)
            self._look(player)

    def _look(self, player: Player) -> None:
        """Note the newest moment that was seen."""
        if player.sight is not None and (not self._seen or player.sight.tick > self._seen[-1][1]):
            self._seen.append((time.monotonic(), player.sight.tick))

    def _note_return(self, before: Sequence[tuple[float, int]], began_at: int | None) -> None:
        """How many seconds of the play seen before are played again."""
        if before and began_at is not None:
            lost = [moment for moment, tick in before if tick > began_at]
            self.kept.returns_s.append(before[-1][0] - lost[0] if lost else 0.0)
        elif began_at is None:
            self._seen.extend(before)
