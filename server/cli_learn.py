"""The verb `varil learn` and its options."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from server.cli_choices import Expert, Scale, Worker
from server.cli_output import AsJson, report


def learn(
    out: Annotated[Path, typer.Option(help="Folder for dataset, policies and discrepancies.")],
    scale: Scale = Scale.STUDY,
    iterations: Annotated[int, typer.Option(min=1, help="25 pairs each.")] = 240,
    seed: Annotated[int, typer.Option(min=0)] = 0,
    expert: Annotated[Expert, typer.Option(help="Who sets the boxes.")] = Expert.TABLE,
    worker: Annotated[Worker, typer.Option(help="Who carries on the work.")] = Worker.BELIEVER,
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
    from server.learning_runs import LearningOptions
    from server.learning_runs import learn as run_learning
    from study.learning.settings import LearningSettings

    settings = LearningSettings(
        iterations=iterations,
        beta=beta,
        box_mode=box_mode,
        label_source=label_source,
        pair_unit=pair_unit,
        classifier=classifier,
        seed=seed,
    )
    options = LearningOptions(
        out=out,
        settings=settings,
        scale=scale.value,
        expert=expert.value,
        worker=worker.value,
        quiet=as_json,
    )
    report(run_learning(options), as_json)
