"""How far policy and expert lie apart, iteration by iteration, beside reference lines.

Only elements that could draw anything are compared: up to 3 in a robot's pair, 1 in a station's.
The paper counts the elements that the policy *proposed* and the expert has off (`disable`). Since a
policy that proposes nothing scores 0 on that, we add the converse (`enable`), both together
(`hamming`), and the share of elements proposed on.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from study.learning.dataset import Dataset, Pair
from study.learning.domains import DOMAINS, count_elements

Ints = npt.NDArray[np.int64]
REFERENCES = ("arroch", "all_off", "majority", "floor")
_COLUMN = {name: at for at, name in enumerate(Pair._fields)}


@dataclass(frozen=True, eq=False)
class Discrepancies:
    """Counts per iteration, int64[J]: elements compared, and among them those that differ."""

    compared: Ints
    disable: Ints
    enable: Ints
    shown: Ints

    def off_rate(self, iterations: slice = slice(None)) -> float:
        """Share of elements proposed on and set off; 0 when nothing was compared."""
        return self._share(self.disable, iterations)

    def hamming_rate(self, iterations: slice = slice(None)) -> float:
        """Share of elements that differ."""
        return self._share(self.disable + self.enable, iterations)

    def shown_share(self, iterations: slice = slice(None)) -> float:
        """Share of elements proposed on."""
        return self._share(self.shown, iterations)

    def _share(self, part: Ints, iterations: slice) -> float:
        whole = int(self.compared[iterations].sum())
        return int(part[iterations].sum()) / whole if whole else 0.0


def compare(columns: Ints, proposals: Ints, iterations: int) -> Discrepancies:
    """Compare proposals int64[pairs] with the boxes of the same pairs."""
    box, drawn = columns[:, _COLUMN["box"]], columns[:, _COLUMN["drawn"]]
    of = columns[:, _COLUMN["iteration"]]

    def total(masks: Ints) -> Ints:
        sums = np.bincount(of, weights=count_elements(masks & drawn), minlength=iterations)
        return sums.astype(np.int64)

    return Discrepancies(
        compared=total(np.full_like(box, 7)),
        disable=total(proposals & ~box),
        enable=total(~proposals & box),
        shown=total(proposals),
    )


def measure(dataset: Dataset, iterations: int) -> Mapping[str, Discrepancies]:
    """Return the run's own discrepancies as `policy`, and each reference line by its name.

    arroch: all of a robot's elements, no balloon. all_off: nothing. majority: for each element
    what the boxes have most often. floor: for each state and element what the boxes have most
    often in it, which no table can undercut. The last two look back over the whole run.
    """
    columns = dataset.columns()
    domain, state = columns[:, _COLUMN["domain"]], columns[:, _COLUMN["state"]]
    flat = np.zeros_like(state)
    lines = {
        "policy": columns[:, _COLUMN["proposal"]],
        "arroch": np.where(domain == 0, 7, 0),
        "all_off": flat,
        "majority": _usual(columns, flat),
        "floor": _usual(columns, state),
    }
    return {name: compare(columns, chosen, iterations) for name, chosen in lines.items()}


def _usual(columns: Ints, group: Ints) -> Ints:
    """For each pair the elements that are mostly on in its group; ties are off."""
    chosen = np.zeros_like(group)
    for number, domain in enumerate(DOMAINS):
        mine = columns[:, _COLUMN["domain"]] == number
        box, drawn = columns[mine, _COLUMN["box"]], columns[mine, _COLUMN["drawn"]]
        for bit in range(domain.elements):
            seen = drawn >> bit & 1
            total = np.bincount(group[mine], weights=seen, minlength=domain.states)
            on = np.bincount(group[mine], weights=seen & box >> bit, minlength=domain.states)
            chosen[mine] |= (on * 2 > total)[group[mine]].astype(np.int64) << bit
    return chosen
