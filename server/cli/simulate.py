"""The verb `varil simulate` and its options."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from server.cli.choices import NO_BALLOONS, BackendName, BalloonBelief, Control, Scale, Worker
from server.cli.output import AsJson, report


def simulate(
    out: Annotated[Path, typer.Option(help="Folder for trials.csv and robots.csv.")],
    condition: Annotated[str, typer.Option(help="varil, arroch, crmiar, none or full.")] = "none",
    policy: Annotated[Path | None, typer.Option(help="Policy file for `varil`.")] = None,
    control: Annotated[
        Control | None, typer.Option(help="For `varil`, a policy that nobody learned.")
    ] = None,
    scale: Scale = Scale.STUDY,
    worker: Worker = Worker.CYCLIC,
    balloon_belief: Annotated[
        BalloonBelief,
        typer.Option(help="Which balloons the believer trusts: came on since its visit, or all."),
    ] = BalloonBelief.ONSET,
    trials: Annotated[int, typer.Option(min=1)] = 10,
    seed: Annotated[int, typer.Option(min=0, max=2**53)] = 0,
    workers: Annotated[
        int | None, typer.Option(min=1, help="Processes; default all cores.")
    ] = None,
    backend: Annotated[
        BackendName, typer.Option(help="Processes here, or a Dask cluster.")
    ] = BackendName.LOKY,
    dask_scheduler: Annotated[
        str, typer.Option(help="Address of a running cluster; default one on this machine.")
    ] = "",
    as_json: AsJson = False,
) -> None:
    """Run trials headless with a simulated worker, on all cores."""
    from server.headless.backends import Backend
    from server.headless.trials import SimulationOptions, run_simulation
    from study.learning.controls import control_policy
    from study.people.habits import Habits

    for option, given in (("--policy", policy), ("--control", control)):
        if given is not None and condition != "varil":
            raise typer.BadParameter(
                f"the condition {condition} follows no policy", param_hint=option
            )
    if policy is not None and control is not None:
        raise typer.BadParameter(
            "give a policy file or a control, not both", param_hint="--control"
        )
    if worker is not Worker.BELIEVER and balloon_belief is not BalloonBelief.ONSET:
        raise typer.BadParameter(NO_BALLOONS, param_hint="--balloon-belief")
    summary = run_simulation(
        SimulationOptions(
            condition=condition,
            policy=control_policy(control.value) if control else policy,
            scale=scale.value,
            habits=Habits(balloon_belief=balloon_belief.value),
            worker=worker.value,
            trials=trials,
            seed=seed,
            backend=Backend(backend.value, workers or os.cpu_count() or 1, dask_scheduler),
            out=out,
            quiet=as_json,
        )
    )
    report(summary, as_json)
