"""Counterbalancing: which order of conditions a participant meets, and on which task sets.

Our choice (the paper says “randomly ordered”): all orders of the conditions, the least-filled one
first, counting completed and active participants; a place is released on drop-out. A *block* is one
set of all orders. The seed of a trial depends on block and position only, so within a block all
orders meet the same task sets. Instead of all orders a study may use a balanced Latin square
(Williams 1949) or a list of its own.
"""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Collection, Sequence
from dataclasses import dataclass


@dataclass(frozen=True, order=True)
class Slot:
    """A place in the design: one order within one block."""

    block: int
    order_index: int


def all_orders(conditions: tuple[str, ...]) -> tuple[tuple[str, ...], ...]:
    """Every permutation, in lexicographic order of positions; index = `Slot.order_index`."""
    return tuple(itertools.permutations(conditions))


def latin_square(conditions: tuple[str, ...]) -> tuple[tuple[str, ...], ...]:
    """A Latin square balanced for first-order carry-over [Williams 1949, doi:10.1071/CH9490149].

    Every condition stands equally often at every position and follows every other equally often:
    n orders for an even number of conditions, 2 n (the square and its mirror) for an odd one.
    """
    n = len(conditions)
    zigzag = [(step + 1) // 2 if step % 2 else (n - step // 2) % n for step in range(n)]
    rows = [tuple(conditions[(k + shift) % n] for k in zigzag) for shift in range(n)]
    if n % 2 and n > 1:
        rows += [row[::-1] for row in rows]
    return tuple(rows)


def count_successions(orders: Sequence[Sequence[str]]) -> dict[tuple[str, str], int]:
    """How often each condition directly follows each other one."""
    pairs = {(a, b): 0 for a in orders[0] for b in orders[0] if a != b}
    for order in orders:
        for pair in itertools.pairwise(order):
            pairs[pair] += 1
    return pairs


def choose_slot(held: Collection[Slot], n_orders: int, study_seed: int, draw: int) -> Slot:
    """The next place to give away.

    Args:
        held: places of completed and active participants of the same mode.
        n_orders: number of orders in the design.
        study_seed: the study's seed; ties between orders are drawn from it.
        draw: how many places were given away before (makes each tie its own draw).
    """
    counts = [sum(slot.order_index == k for slot in held) for k in range(n_orders)]
    least = [k for k, count in enumerate(counts) if count == min(counts)]
    order_index = least[_digest_int("order", study_seed, draw) % len(least)]
    taken_blocks = {slot.block for slot in held if slot.order_index == order_index}
    block = next(b for b in itertools.count() if b not in taken_blocks)
    return Slot(block, order_index)


def trial_seed(study_seed: int, block: int, position: int) -> int:
    """Seed of the trial at `position` (1-based) of a block: 63 bits, the same for all orders."""
    return _digest_int("trial", study_seed, block, position)


def practice_seed(study_seed: int, attempt: int) -> int:
    """Seed of the practice trial's `attempt` (1-based), the same for everybody."""
    return _digest_int("practice", study_seed, attempt)


def _digest_int(*parts: object) -> int:
    """63 bits of SHA-256 over the parts; the same on every machine."""
    text = "\x1f".join(str(part) for part in parts)
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:8], "big") >> 1
