"""The experts of a run: whose pages are there, whose boxes count, and which messages were taken.

A page is known by 16 hexadecimal digits it gave itself. Who leads keeps the lead while away; the
first to come to a run without a lead has it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from study.errors import JournalError, WrongMoment


class Panel:
    """`present`: account name by page, in the order of arrival. `lead`: a page, None at first."""

    def __init__(self) -> None:
        self.present: dict[str, str] = {}
        self.lead: str | None = None
        self._names: dict[str, str] = {}
        self._taken: dict[str, int] = {}

    @property
    def is_led(self) -> bool:
        """Whether the page that leads is there."""
        return self.lead in self.present

    @property
    def lead_name(self) -> str | None:
        """The account of the page that leads."""
        return None if self.lead is None else self._names[self.lead]

    def name_of(self, page: str) -> str:
        """The account of a page. Errors: JournalError for one that never came."""
        if page not in self._names:
            raise JournalError(
                f"the page {page[:16]} acts without having joined",
                next_step="A part of the journal is missing; restore this trial from a backup.",
            )
        return self._names[page]

    def is_known_as_another(self, page: str, expert: str) -> bool:
        """Whether this page belongs to somebody else's account."""
        return self._names.get(page, expert) != expert

    def taken_seq(self, page: str) -> int:
        """The number of the last message of this page that was taken, 0 before the first."""
        return self._taken.get(page, 0)

    def taken_by_page(self) -> dict[str, int]:
        """The same for every page that said anything."""
        return dict(self._taken)

    # ---- what happened ----------------------------------------------------------------------

    def add(self, expert: str, page: str) -> None:
        """A page is there."""
        self._names[page] = expert
        self.present[page] = expert

    def remove(self, page: str) -> None:
        """A page is gone."""
        self.present.pop(page, None)

    def give_lead(self, page: str) -> None:
        """From now on this page's boxes count."""
        self.name_of(page)
        self.lead = page

    def take(self, page: str, seq: int) -> None:
        """A page's message of this number was taken."""
        self._taken[page] = max(seq, self.taken_seq(page))

    # ---- what may happen --------------------------------------------------------------------

    def check_taking(self, page: str) -> None:
        """Whether this page may take the lead. Errors: WrongMoment while somebody leads."""
        if self.is_led and self.lead != page:
            raise WrongMoment(
                f"{self.lead_name} leads and is connected",
                next_step="Ask them to hand the lead over.",
            )

    def check_handing(self, page: str, to: str) -> None:
        """Whether `page` may hand the lead to `to`. Errors: WrongMoment."""
        if self.lead != page:
            raise WrongMoment("only the expert who leads can hand the lead over")
        if to not in self.present:
            raise WrongMoment(
                "the expert who was to take over is not connected any more",
                next_step="Choose one of those who are listed.",
            )

    # ---- between trials ---------------------------------------------------------------------

    def to_json(self) -> dict[str, Any]:
        """All that carries over; nobody counts as present before joining the next trial."""
        pages = {page for page in self._names if page == self.lead or page in self._taken}
        return {
            "lead": self.lead,
            "pages": {page: [self._names[page], self.taken_seq(page)] for page in sorted(pages)},
        }

    @classmethod
    def from_json(cls, record: Mapping[str, Any]) -> Panel:
        """The panel that `to_json` described."""
        panel = cls()
        for page, (expert, seq) in record["pages"].items():
            panel._names[page] = expert
            if seq:
                panel._taken[page] = seq
        panel.lead = record["lead"]
        return panel
