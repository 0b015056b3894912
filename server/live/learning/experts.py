"""The experts of one run: who sits where, what they do to the present trial, what they are told.

Importing this module loads numba; the server does so after it answers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

from server.live.learning import telling, wire
from server.live.learning.record import RunRecord
from server.live.learning.room import LearningRoom
from server.live.ports import TrialBatch
from server.live.sink import Sink
from server.live.wire import CloseCode
from study.ar.drawn import drawn_elements
from study.errors import StudyError, WrongMoment
from study.learning.session import Entry, LearningSession

ACKNOWLEDGED = ("expert_set", "expert_confirmed")
BETWEEN_TRIALS = "this trial has ended, so nothing was changed; the next begins in a moment"


@dataclass(frozen=True, eq=False)
class Seat:
    """One page of one expert."""

    sink: Sink
    name: str
    client: str


class Experts:
    """Seats by page, and up to which number each page's messages are stored."""

    def __init__(self, record: RunRecord) -> None:
        self._record = record
        self._seats: dict[str, Seat] = {}
        self._stored: dict[str, int] = {}

    def __iter__(self) -> Iterator[Seat]:
        return iter(tuple(self._seats.values()))

    def __len__(self) -> int:
        return len(self._seats)

    # ---- coming and going -------------------------------------------------------------------

    def join(self, room: LearningRoom, seat: Seat) -> None:
        """A page comes; an older socket of the same page is closed. Raises WrongMoment."""
        older = self._seats.get(seat.client)
        if older is not None and older.name == seat.name:
            self.leave(room, older)
            older.sink.close(CloseCode.TAKEN_OVER, "this page has a newer connection")
        room.record(room.session.join(seat.name, seat.client))
        self._seats[seat.client] = seat
        taken = room.session.panel.taken_seq(seat.client)
        send = seat.sink.send_text
        send(telling.tell_run(self._record, (seat.name, seat.client), taken))
        if self._stored.get(seat.client):
            send(wire.encode_stored(self._stored[seat.client]))
        room.watch(seat.sink)
        send(telling.tell_curve(self._record, 0))
        send(telling.tell_agreement(self._record))
        self.tell_present(room)
        self.tell_state(room)

    def leave(self, room: LearningRoom, seat: Seat) -> None:
        """A page is gone; ignored if a newer socket has taken its seat."""
        if self._seats.get(seat.client) is seat:
            del self._seats[seat.client]
            room.leave(seat.sink, CloseCode.NORMAL)
            room.record(room.session.leave(seat.client))
            self.tell_present(room)

    def bring_along(self, room: LearningRoom) -> None:
        """Everybody who is here joins the trial that begins; before anything is told of it."""
        for seat in self:
            room.record(room.session.join(seat.name, seat.client))

    def show(self, room: LearningRoom) -> None:
        """Everybody who is here sees the trial that begins."""
        for seat in self:
            room.watch(seat.sink)
        self.tell_present(room)
        self.tell_state(room)

    def send_away(self, last_words: str | None, close: tuple[CloseCode, str] | None) -> None:
        """Everybody goes, after a last text and with a close code unless somebody else closes."""
        for seat in self:
            if last_words is not None:
                seat.sink.send_text(last_words)
            if close is not None:
                seat.sink.close(*close)
        self._seats.clear()

    # ---- what they do -----------------------------------------------------------------------

    def edit(self, room: LearningRoom, seat: Seat, message: wire.Edit | wire.Confirm) -> None:
        """Apply a message, or say why not; one that was taken already is only acknowledged."""
        session, stored = room.session, self._stored.get(seat.client, 0)
        if message.seq <= session.panel.taken_seq(seat.client):
            if message.seq <= stored:
                seat.sink.send_text(wire.encode_stored(stored))
            return
        try:
            _check_open(room)
            session.check_moment(message.trial, message.tick)
            if isinstance(message, wire.Edit):
                entries = session.edit(seat.client, message.seq, message.changes)
            else:
                entries = session.confirm(seat.client, message.seq, message.agents)
        except StudyError as problem:
            seat.sink.send_text(wire.encode_refused(message.seq, problem.sentence))
            return
        room.record(entries)
        drawn = drawn_elements(room.world)
        seat.sink.send_text(telling.tell_agents(session, seat.client, drawn))

    def change_lead(
        self,
        room: LearningRoom,
        seat: Seat,
        change: Callable[[LearningSession], tuple[Entry, ...]],
    ) -> None:
        """The lead goes to another page. Who asks in vain is told who is there: that is why."""
        try:
            _check_open(room)
            room.record(change(room.session))
        except WrongMoment:
            seat.sink.send_text(telling.tell_experts(room.session.panel))
        else:
            self.tell_present(room)
            self.tell_state(room)

    # ---- what they are told -----------------------------------------------------------------

    def tell(self, text: str) -> None:
        """Send a text to all."""
        for seat in self:
            seat.sink.send_text(text)

    def tell_present(self, room: LearningRoom) -> None:
        """Who is there, and who leads."""
        self.tell(telling.tell_experts(room.session.panel))

    def tell_state(self, room: LearningRoom) -> None:
        """To each page its boxes, and how far the run is."""
        if self._seats:
            session, drawn = room.session, drawn_elements(room.world)
            policy_sha256 = self._record.hash_of(session.up.versions[-1].iterations)
            progress = telling.tell_progress(session, policy_sha256)
            for seat in self:
                seat.sink.send_text(telling.tell_agents(session, seat.client, drawn))
                seat.sink.send_text(progress)

    def note_stored(self, messages: Iterable[tuple[str, int]]) -> None:
        """Messages (page, number) are stored; their pages are told."""
        newest: dict[str, int] = {}
        for client, seq in messages:
            newest[client] = max(seq, newest.get(client, 0), self._stored.get(client, 0))
        for client, seq in newest.items():
            self._stored[client] = seq
            seat = self._seats.get(client)
            if seat is not None:
                seat.sink.send_text(wire.encode_stored(seq))


def messages_in(batch: TrialBatch) -> Iterator[tuple[str, int]]:
    """Page and number of each message that a batch stores."""
    for event in batch.events:
        if event.kind in ACKNOWLEDGED:
            yield str(event.data["client"]), int(event.data["seq"])


def _check_open(room: LearningRoom) -> None:
    if room.result is not None:
        raise WrongMoment(BETWEEN_TRIALS)
