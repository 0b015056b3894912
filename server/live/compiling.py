"""Getting the compiled world ready while the server already answers.

A first compilation takes tens of seconds of processor time, so it is done by another process that
fills the kernel cache; this one then loads the machine code within moments. If the cache cannot
be written, this process compiles for itself, in a thread.
"""

from __future__ import annotations

import asyncio
import gc
import logging
import sys
import time
from pathlib import Path

from server.kernel_cache import use_kernel_cache

logger = logging.getLogger(__name__)

COMPLETE = ".complete"
_PROGRAM = (
    "import sys, pathlib\n"
    "from server.live.compiling import choose_cache, load_kernels\n"
    "load_kernels(choose_cache(pathlib.Path(sys.argv[1])))\n"
)


def choose_cache(folder: Path) -> Path | None:
    """The folder that keeps the machine code of just these sources; None if not writable."""
    try:
        return use_kernel_cache(folder)
    except OSError as problem:
        logger.warning("no kernel cache (%s); the world is compiled at each start", problem)
        return None


def load_kernels(place: Path | None) -> None:
    """Load every kernel that a trial needs, compiling what `place` does not hold."""
    from study.ar.conditions import Varil
    from study.ar.elements import Display
    from study.learning.policy import initial_policy
    from study.people.worker import Believer
    from study.warehouse.layout import PRESETS, build_layout
    from study.warehouse.world import World, compile_kernels

    compile_kernels()
    layout = build_layout(PRESETS["practice"])
    world = World(layout, seed=1)
    nothing = Display.nothing(layout.spec.robots, len(layout.stations))
    Varil(initial_policy()).decide(world, nothing)
    Believer(world, seed=1).next_frame(nothing)
    if place is not None:
        (place / COMPLETE).touch()


def settle_memory() -> None:
    """Spare the garbage collector what lives as long as the process.

    The compiler and the libraries leave some hundred thousand objects behind; walking over them
    would stop every trial for a tenth of a second now and then.
    """
    gc.collect()
    gc.freeze()


async def prepare_kernels(folder: Path) -> None:
    """Make the kernels ready in this process without keeping its sockets waiting for long."""
    started_s = time.perf_counter()
    place = await asyncio.to_thread(choose_cache, folder)
    if place is not None and not (place / COMPLETE).exists():
        logger.info("Compiling the warehouse for this machine, once; pages answer meanwhile ...")
        process = await asyncio.create_subprocess_exec(sys.executable, "-c", _PROGRAM, str(folder))
        try:
            await process.wait()
        finally:
            if process.returncode is None:
                process.kill()
    await asyncio.to_thread(load_kernels, place)
    settle_memory()
    logger.info("The warehouse is ready (%.1f s).", time.perf_counter() - started_s)
