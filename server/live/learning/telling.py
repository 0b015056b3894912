"""What the experts of a run are told, as texts. Agents: robots from 0, then stations."""

from __future__ import annotations

from typing import TYPE_CHECKING

from server.live.learning.wire import EXPERT_VERSION, encode_ended
from server.live.wire import encode_text
from study.learning.agreement import ELEMENTS
from study.learning.settings import PAIRS_PER_ITERATION, SNAPSHOT_TICKS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from server.live.learning.record import RunRecord
    from study.learning.panel import Panel
    from study.learning.session import LearningSession


def tell_ended(record: RunRecord, you: tuple[str, str], status: str) -> list[str]:
    """Everything there is to say of a run that is over."""
    return [
        tell_run(record, you, 0),
        tell_curve(record, 0),
        tell_agreement(record),
        encode_ended(status),
    ]


def tell_run(record: RunRecord, you: tuple[str, str], taken_seq: int) -> str:
    """The first answer to a page: what the run is, and which of its messages were taken."""
    setup = record.setup
    return encode_text(
        {
            "type": "run",
            "run_id": setup.run_id,
            "version": EXPERT_VERSION,
            "robots": setup.spec.robots,
            "stations": setup.spec.stations,
            "settings": setup.settings.to_json(),
            "worker": setup.worker,
            "you": {"name": you[0], "client": you[1]},
            "pairs_per_iteration": PAIRS_PER_ITERATION,
            "snapshot_ticks": SNAPSHOT_TICKS,
            "taken_seq": taken_seq,
        }
    )


def tell_agents(session: LearningSession, page: str, drawn: Sequence[int]) -> str:
    """A page's boxes, as its messages up to `taken_seq` have made them, beside what the policy
    proposes and what could draw anything.
    """
    up = session.up
    return encode_text(
        {
            "type": "agents",
            "trial": up.trial,
            "tick": session.tick,
            "boxes": session.boxes_of(page).masks,
            "proposals": up.boxes.proposals,
            "drawn": list(drawn),
            "by_expert": up.by_expert.astype(int).tolist(),
            "recording": up.is_recording,
            "taken_seq": session.panel.taken_seq(page),
        }
    )


def tell_progress(session: LearningSession, policy_sha256: str) -> str:
    """How far the run is, and when the next snapshot is due."""
    up, settings = session.up, session.up.settings
    return encode_text(
        {
            "type": "progress",
            "trial": up.trial,
            "tick": session.tick,
            "pairs": len(up.dataset),
            "units": up.units,
            "iteration": up.j,
            "iterations": settings.iterations,
            "beta": settings.beta_of(up.j),
            "policy_sha256": policy_sha256,
            "next_snapshot_tick": (session.tick // SNAPSHOT_TICKS + 1) * SNAPSHOT_TICKS,
        }
    )


def tell_curve(record: RunRecord, first: int) -> str:
    """The discrepancies of the iterations from `first` on whose pairs are stored.

    Without the reference lines `majority` and `floor`: they look back over the whole dataset.
    """
    lines = record.curve.to_json(first, record.stored_iterations)
    return encode_text({"type": "curve", "from": first, "lines": lines})


def tell_experts(panel: Panel) -> str:
    """Who is there, and whose boxes count."""
    present = [{"name": name, "client": page} for page, name in panel.present.items()]
    lead = panel.lead if panel.is_led else None
    return encode_text({"type": "experts", "lead": lead, "present": present})


def tell_agreement(record: RunRecord) -> str:
    """How far each expert without the lead agrees with the one who has it."""
    found = record.agreement
    experts = [
        {
            "name": expert,
            "elements": {
                name: {"kappa": found.kappa(expert, name), "pairs": found.pairs(expert, name)}
                for name in ELEMENTS
            },
        }
        for expert in found.experts()
    ]
    return encode_text({"type": "agreement", "experts": experts})
