"""The verb `varil learn` and its options."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from server.cli.choices import NO_BALLOONS, BalloonBelief, Expert, Scale, View, Wish, Worker
from server.cli.output import AsJson, report
from study.errors import InvalidValue

if TYPE_CHECKING:
    from study.learning.settings import LearningSettings

LAST = 40
LINES = {
    "policy": "the policy learned",
    "arroch": "ARROCH",
    "all_off": "control all_off",
    "majority": "control majority",
    "floor": "floor of any table",
}


def learn(
    out: Annotated[Path, typer.Option(help="Folder for dataset, policies and discrepancies.")],
    scale: Scale = Scale.STUDY,
    iterations: Annotated[int, typer.Option(min=1, help="25 pairs each.")] = 240,
    seed: Annotated[int, typer.Option(min=0)] = 0,
    expert: Annotated[Expert, typer.Option(help="Who sets the boxes.")] = Expert.PERSON,
    wish: Annotated[Wish, typer.Option(help="What the expert `person` wants.")] = Wish.DECLUTTER,
    view: Annotated[View, typer.Option(help="The picture that `person` sees.")] = View.WORKER,
    worker: Annotated[Worker, typer.Option(help="Who carries on the work.")] = Worker.BELIEVER,
    balloon_belief: Annotated[
        BalloonBelief,
        typer.Option(help="Which balloons the believer trusts: came on since its visit, or all."),
    ] = BalloonBelief.ONSET,
    pair_unit: Annotated[str, typer.Option(help="agent or snapshot.")] = "agent",
    beta: Annotated[str, typer.Option(help="linear, exponential(p) or first_only.")] = "linear",
    classifier: Annotated[
        str, typer.Option(help="svm, per_element, majority or cost_sensitive.")
    ] = "svm",
    box_mode: Annotated[str, typer.Option(help="follow or independent.")] = "follow",
    label_source: Annotated[str, typer.Option(help="boxes, events or confirmed.")] = "boxes",
    as_json: AsJson = False,
) -> None:
    """Learn a policy from a simulated expert by PolicyUp."""
    from server.headless.learning import LearningOptions
    from server.headless.learning import learn as run_learning
    from study.people.habits import Habits

    settings = read_settings(
        iterations=iterations,
        beta=beta,
        box_mode=box_mode,
        label_source=label_source,
        pair_unit=pair_unit,
        classifier=classifier,
        seed=seed,
    )
    if expert is Expert.TABLE and (wish, view) != (Wish.DECLUTTER, View.WORKER):
        raise typer.BadParameter(
            "only the expert person has wishes and views", param_hint="--expert"
        )
    if worker is not Worker.BELIEVER and balloon_belief is not BalloonBelief.ONSET:
        raise typer.BadParameter(NO_BALLOONS, param_hint="--balloon-belief")
    habits = Habits(balloon_belief=balloon_belief.value, wish=wish.value, view=view.value)
    options = LearningOptions(
        out=out,
        settings=settings,
        scale=scale.value,
        habits=habits,
        expert=expert.value,
        worker=worker.value,
        quiet=as_json,
    )
    report(run_learning(options), as_json)
    if not as_json:
        typer.echo()
        typer.echo(describe_rates(out / "discrepancies.csv"))


def read_settings(**given: Any) -> LearningSettings:
    """The options as settings of a run; what is not allowed makes the call a wrong one."""
    from study.learning.classifiers import choose_classifier
    from study.learning.settings import LearningSettings

    try:
        choose_classifier(given["classifier"])
        return LearningSettings(**given)
    except InvalidValue as problem:
        name = (problem.where or "classifier").replace("_", "-")
        raise typer.BadParameter(
            f"{problem.what}. {problem.next_step}", param_hint=f"--{name}"
        ) from problem


def describe_rates(file: Path) -> str:
    """A small table of the last 40 iterations' rates, the policy's own beside what it is held
    against, added up from the counts in discrepancies.csv. A shorter run counts as a whole."""
    totals: dict[str, list[int]] = {}
    with file.open(newline="", encoding="utf-8") as opened:
        rows = list(csv.DictReader(opened))
    iterations = max(int(row["iteration"]) for row in rows) + 1
    first = iterations - LAST
    for row in rows:
        if int(row["iteration"]) >= first:
            counts = totals.setdefault(row["line"], [0, 0, 0, 0])
            for at, name in enumerate(("compared", "disable", "enable", "shown")):
                counts[at] += int(row[name])
    title = f"last {min(LAST, iterations)} iterations"
    lines = [f"{title:<20}  {'off rate':>8}  {'Hamming rate':>12}  {'shown share':>11}"]
    for line, (compared, disable, enable, shown) in totals.items():
        rates = [part / max(1, compared) for part in (disable, disable + enable, shown)]
        name = LINES.get(line, line)
        lines.append(f"{name:<20}  {rates[0]:8.3f}  {rates[1]:12.3f}  {rates[2]:11.3f}")
    return "\n".join(lines)
