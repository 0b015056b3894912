"""docs/results.md, written from the findings."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from server.results.findings import REFERENCES, Findings, Mode
from server.results.plan import Size, points
from server.results.words import (
    NAMES,
    RULES,
    bounds,
    fall,
    judge,
    plain,
    seconds,
    share,
    signed,
    tell_fall,
    tell_left,
    tell_shorter,
)

MEASURES = {
    "disable": ("the paper's count, elements an iteration", 1),
    "enable": ("the converse count, elements an iteration", 1),
    "off_rate": ("the paper's count per element compared", 2),
    "hamming_rate": ("elements that differ per element compared", 2),
    "shown_share": ("elements proposed on per element compared", 2),
}
TIMES = {
    "sum_wait_s": "waiting, added up",
    "sum_completion_s": "completion times, added up",
    "slowest_robot_s": "the slowest robot",
}
CLAIMS = {
    "i": "(i) discrepancies fall steeply, ARROCH's stay flat",
    "ii": "(ii) waiting is shorter than under ARROCH and CRMIAR for most teams",
    "iii": "(iii) waiting moves left from P1 to P6",
}


def write_report(found: Findings, size: Size, versions: Mapping[str, str], pictures: str) -> str:
    """The whole page; `pictures`: the folder of the figures, as seen from the page."""
    parts = [
        _head(found, size, versions),
        _claim_one(found, pictures),
        _claim_two(found, pictures),
        _claim_three(found, pictures),
        _sides(found, pictures),
        _sensitivity(found, pictures),
        _limits(found, size),
    ]
    return "\n".join(parts)


def _head(found: Findings, size: Size, versions: Mapping[str, str]) -> str:
    verdicts = [judge(mode) for mode in found.modes]
    rows = [[CLAIMS[claim], *(each[claim].value for each in verdicts)] for claim in CLAIMS]
    libraries = ", ".join(f"{name} {version}" for name, version in versions.items())
    heads = ["claim of the paper", *(f"boxes {mode.name}" for mode in found.modes)]
    return f"""# Results with simulated people

Made by `make results` from [a plan written beforehand](results-plan.md); this page is written by a
program from the numbers, and its sentences for either outcome were fixed before the run. **All of
it comes from simulated people and says nothing about people.** What they are and how they decide
stands in [simulated-people.md](simulated-people.md).

{_table(heads, rows)}

Size: scale `{size.scale}`, {size.iterations} iterations, {size.runs} learning runs for each box
mode, {size.trials} trials on common seeds from {size.first_seed}. Versions: {libraries}.

{_wrap(_terms(found, size))}

{_wrap(RULES)}

Square brackets hold 95 % bootstrap intervals over learning runs and trials drawn apart. With so
few learning runs they are somewhat too narrow. There are no p-values: the number of simulated
teams is ours to choose.
"""


def _terms(found: Findings, size: Size) -> str:
    """What the words of the page mean that are no common ones."""
    last = found.modes[0].steps[-1][0]
    after = ", ".join(str(point) for point in points(size))
    return (
        f"P1 to {last} are the policies after {after} iterations, so P1 shows everything and "
        f"{last} is what was learned. With boxes that `follow`, each of the expert's checkboxes "
        "takes the policy's new proposals and the expert corrects; with `independent` ones it "
        "keeps what the expert set last. *Waiting* is the time that all robots of a trial stood "
        "at a station, added up."
    )


def _claim_one(found: Findings, pictures: str) -> str:
    lines = ["## (i) Discrepancies over the iterations", ""]
    for mode in found.modes:
        lines += [*_lines(f"Boxes `{mode.name}`: {tell_fall(mode)}"), ""]
        rows = [
            [text, *(fall(each, digits) for each in mode.falls[measure])]
            for measure, (text, digits) in MEASURES.items()
        ]
        heads = ["first to last sixth of the iterations", "VARIL", "ARROCH"]
        lines += [_table(heads, rows), "", _picture(f"discrepancies-{mode.name}", pictures), ""]
    lines += _lines(
        "The paper's count falls for any policy that hides enough, so read it beside the converse "
        "count and the share of elements that differ, which hiding alone cannot lower. In the last "
        "panel of each figure stands what share of the elements the policy proposed to show."
    )
    return "\n".join([*lines, ""])


def _claim_two(found: Findings, pictures: str) -> str:
    last = found.modes[0].steps[-1][0]
    lines = [f"## (ii) Waiting under {last} and the other displays", ""]
    for mode in found.modes:
        lines += [*_lines(f"Boxes `{mode.name}`: {tell_shorter(mode)}"), ""]
    rows = [
        [
            f"{last} `{mode.name}` - {NAMES[reference]}",
            TIMES[measure],
            *_cells(mode, reference, measure),
        ]
        for mode in found.modes
        for reference in REFERENCES
        for measure in TIMES
    ]
    heads = ["pair", "measure", "mean difference", "share of teams with less"]
    lines += [_table(heads, rows), "", _picture("differences", pictures), ""]
    rows = [
        [f"`{name}`", plain(found.means[name])]
        + [seconds(pairs[reference]) if reference in pairs else "" for reference in REFERENCES]
        for name, pairs in found.controls.items()
    ]
    heads = ["display or control", "waiting, s", *(f"minus {NAMES[name]}" for name in REFERENCES)]
    lines += [_table(heads, rows), "", _picture("waits-conditions", pictures), ""]
    lines += _lines(
        "`none` shows nothing, `full` everything (so it is P1), `all_off` and `no_ghost` are "
        "policies made by hand; the oracle worker knows all without looking, the cyclic worker "
        "visits the stations in order. They bound what any display could gain here. A mean "
        f"difference of about {found.detectable_s:.0f} s is the smallest that this many trials of "
        "two fixed displays find in four of five cases."
    )
    return "\n".join([*lines, ""])


def _claim_three(found: Findings, pictures: str) -> str:
    lines = ["## (iii) Waiting from P1 to P6", ""]
    for mode in found.modes:
        lines += [*_lines(f"Boxes `{mode.name}`: {tell_left(mode)}"), ""]
    rows = [
        [name, *(plain(mode.steps[at][1]) for mode in found.modes)]
        + [_step(mode, at) for mode in found.modes]
        for at, (name, _, _) in enumerate(found.modes[0].steps)
    ]
    heads = ["policy", *(f"waiting, s, `{mode.name}`" for mode in found.modes)]
    heads += [f"minus P1, `{mode.name}`" for mode in found.modes]
    lines += [_table(heads, rows), ""]
    for mode in found.modes:
        lines += [_picture(f"waits-policies-{mode.name}", pictures), ""]
    return "\n".join(lines)


def _sides(found: Findings, pictures: str) -> str:
    rows = [
        [
            side.name,
            seconds(side.pair),
            share(side.pair.shorter),
            f"{side.differing:.2f}",
            f"{side.shown:.2f}",
        ]
        for side in found.sides
    ]
    heads = ["way of learning", "waiting minus ARROCH", "teams with less", "differing", "shown"]
    said = _lines(
        "What comes out depends on what the expert wants and sees, on the classifier, and on what "
        "counts as a pair. Only the named thing differs from the default: the wish `declutter`, "
        "the view of the worker, the classifier `svm`, pairs of single agents. *Differing* and "
        "*shown* are shares of the elements compared in the last sixth of the iterations."
    )
    lines = ["## Other experts, classifiers and pairs", "", *said, "", _table(heads, rows), ""]
    return "\n".join([*lines, _picture("sides", pictures), ""])


def _sensitivity(found: Findings, pictures: str) -> str:
    below = sum(pair.seconds.high < 0 for pair in found.changed.values())
    above = sum(pair.seconds.low > 0 for pair in found.changed.values())
    total = len(found.changed)
    rows = [["nothing changed", seconds(found.base), plain_mean(found.base.their_mean)]]
    rows += [
        [change, seconds(pair), plain_mean(pair.their_mean)]
        for change, pair in found.changed.items()
    ]
    heads = ["changed", "waiting minus ARROCH", "ARROCH, s"]
    said = _lines(
        "The six parameters that moved an earlier prototype's comparison furthest, halved and "
        f"doubled within their limits, learned anew each time. Of {total} changes {below} put the "
        f"whole interval below 0, {above} above; with {total} intervals of 95 % about "
        f"{total * 0.05:.1f} would miss 0 by chance alone if nothing differed."
    )
    lines = ["## One parameter changed", "", *said, "", _table(heads, rows), ""]
    return "\n".join([*lines, _picture("sensitivity", pictures), ""])


def _limits(found: Findings, size: Size) -> str:
    said = _lines(
        "Simulated people can speak about (i) to (iii) only: whether completion times differ "
        "significantly between people, and what people answer in a questionnaire, needs people. "
        "Clutter is a count of elements in view, not what it looks like; crowding, fatigue and "
        "learning of the worker are left out; the worker walks and decides by rules of our choice. "
        "One hall was tried. The expert watches without pauses and wants the same all the time."
    )
    ends = _lines(
        f"{found.timed_out} trials ended at their cap. The first {size.early_runs} learning runs "
        f"were also run with P2 to P5; other ways and changed parameters used {size.side_runs} "
        f"learning runs and the first {size.side_trials} seeds. All numbers stand as CSV in "
        "[the folder of the figures](results/)."
    )
    return "\n".join(["## What this cannot say", "", *said, "", *ends, ""])


def plain_mean(value: float) -> str:
    """A mean of seconds."""
    return f"{value:.0f}"


def _cells(mode: Mode, reference: str, measure: str) -> list[str]:
    pair = mode.shorter[reference][measure]
    part = signed(100 * pair.seconds.mean / pair.their_mean, 1) if pair.their_mean else "0"
    return [f"{seconds(pair)} ({part} %)", share(pair.shorter)]


def _step(mode: Mode, at: int) -> str:
    pair = mode.steps[at][2]
    return f"{signed(pair.seconds.mean)} {bounds(pair.seconds)}" if pair else ""


def _picture(name: str, pictures: str) -> str:
    words = name.replace("-", " ")
    return f"![{words}, simulated people]({pictures}/{name}.svg)"


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [f"| {' | '.join(heads)} |", f"|{'---|' * len(heads)}"]
    return "\n".join([*lines, *(f"| {' | '.join(row)} |" for row in rows)])


def _wrap(text: str) -> str:
    return "\n".join(_lines(text))


def _lines(text: str, width: int = 100) -> list[str]:
    """The text in lines, broken between words."""
    lines, line = [], ""
    for word in text.split():
        if line and len(line) + 1 + len(word) > width:
            lines.append(line)
            line = word
        else:
            line = f"{line} {word}" if line else word
    return [*lines, line]
