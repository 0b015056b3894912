"""The cache of compiled code: it is used, it never lies, and no index runs out of bounds."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import study
from server.kernel_cache import kernel_digest
from study.headless import simulate_trial
from study.warehouse.kernels import kernel
from study.warehouse.layout import PRESETS, build_layout

ROOT = Path(study.__file__).parent.parent
CACHE = ROOT / "var" / "kernels"

RUN_TRIAL = """
import sys, pathlib
from server.kernel_cache import use_kernel_cache
use_kernel_cache(pathlib.Path(sys.argv[1]))
from study.headless import simulate_trial
from study.warehouse.layout import PRESETS, build_layout
from study.people.patrols import run_patrol
trial = simulate_trial(build_layout(PRESETS["practice"]), 5, "blocker")
print(trial.state_hash.hex(), sum(run_patrol.stats.cache_misses.values()))
"""


def run_fresh(program: str, folder: Path, root: Path = ROOT, **variables: str) -> list[str]:
    """Run a program in a new process with the packages of `root`; return its words."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith("NUMBA_")}
    environment |= {"PYTHONPATH": str(root), "PYTHONDONTWRITEBYTECODE": "1"} | variables
    words = [sys.executable, "-c", program, str(folder)]
    done = subprocess.run(words, env=environment, cwd=root, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


def test_cached_code_loads_in_a_fresh_process_and_gives_the_same_bits() -> None:
    """Guards the cache across processes (a recursive kernel once crashed there) and determinism."""
    here = simulate_trial(build_layout(PRESETS["practice"]), 5, "blocker").state_hash.hex()
    assert run_fresh(RUN_TRIAL, CACHE)[0] == here
    assert run_fresh(RUN_TRIAL, CACHE) == [here, "0"]


def test_an_edited_callee_is_seen_by_its_callers(tmp_path: Path) -> None:
    """Guards against stale code: the caller's own file stays, its callee's result changes."""
    copy = tmp_path / "copy"
    shutil.copytree(ROOT / "study", copy / "study", ignore=shutil.ignore_patterns("__pycache__"))
    (copy / "server").mkdir()
    for name in ("__init__.py", "kernel_cache.py"):
        shutil.copy(ROOT / "server" / name, copy / "server" / name)
    routes = copy / "study" / "warehouse" / "routes.py"
    routes.write_text(routes.read_text() + CALLEE)
    caller = copy / "study" / "people" / "caller.py"
    caller.write_text(CALLER)
    program = PROGRAM
    assert run_fresh(program, tmp_path / "kernels", copy) == ["1"]
    routes.write_text(routes.read_text().replace("return 1  # answer", "return 2  # answer"))
    assert run_fresh(program, tmp_path / "kernels", copy) == ["2"]


CALLEE = '''

@kernel
def answer() -> int:
    """Answer."""
    return 1  # answer
'''
CALLER = '''
from study.warehouse.kernels import kernel
from study.warehouse.routes import answer


@kernel
def ask() -> int:
    """Ask the callee in the other file."""
    return answer()
'''
PROGRAM = """
import sys, pathlib
from server.kernel_cache import use_kernel_cache
use_kernel_cache(pathlib.Path(sys.argv[1]))
from study.people.caller import ask
print(ask())
"""


def test_no_index_runs_out_of_bounds() -> None:
    """Guards against silent reads outside of arrays: a whole trial with bounds checks on."""
    here = simulate_trial(build_layout(PRESETS["practice"]), 5, "blocker").state_hash.hex()
    folder = ROOT / "var" / "kernels-checked"
    assert run_fresh(RUN_TRIAL, folder, NUMBA_BOUNDSCHECK="1", NUMBA_OPT="0")[0] == here


def test_kernels_outside_of_the_hash_are_refused() -> None:
    """Guards that no compiled function can be missing from the hash of sources."""

    def stray() -> int:
        return 1

    stray.__module__ = "study.protocol.orders"
    with pytest.raises(RuntimeError, match=r"study\.protocol\.orders"):
        kernel(stray)


def test_digest_is_stable() -> None:
    """Guards that two processes with the same sources share one folder."""
    assert kernel_digest() == kernel_digest()
    assert len(kernel_digest()) == 16
