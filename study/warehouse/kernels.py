"""The decorator of every compiled function, and the folder that keeps their machine code.

A compiled function is cached on disk under its own source file only: a change in a function that it
calls, in another file, would go unseen and the old machine code would go on answering. So all code
lives in one folder named by a hash of *all* kernel sources and of the compiler's versions, chosen
by `use_kernel_cache`. Nothing here touches a file before that call: without it, functions are
compiled anew in each process.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

F = TypeVar("F", bound=Callable[..., Any])

KERNEL_PACKAGES = ("warehouse", "ar", "people")
"""The packages of `study` in which compiled functions may live: all their sources enter the hash.
"""

_kernels: list[Any] = []
_folder: list[Path] = []


def kernel(function: F) -> F:
    """Compile `function` at its first call, with exact arithmetic and the folder chosen, if any."""
    package = function.__module__.split(".")
    if len(package) < 3 or package[1] not in KERNEL_PACKAGES:
        raise RuntimeError(
            f"{function.__module__}.{function.__qualname__} is compiled outside of "
            f"the packages {KERNEL_PACKAGES} of study: the cache's hash would miss its source."
        )
    dispatcher = numba.njit(function, error_model="numpy")
    _kernels.append(dispatcher)
    if _folder:
        dispatcher.enable_caching()
    return cast(F, dispatcher)


def compiled_entry(function: F, *arguments: object) -> F:
    """Return the machine code of a kernel for arguments of exactly these types.

    A call of the kernel itself first looks at the type of each argument, which for many arrays
    takes longer than a small kernel. The types given to what is returned are not checked.
    """
    dispatcher: Any = function
    if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
        return function
    types = tuple(numba.typeof(argument) for argument in arguments)  # type: ignore[no-untyped-call]
    dispatcher.compile(types)
    return cast(F, dispatcher.overloads[types].entry_point)


def kernel_digest() -> str:
    """Return 16 hex digits over all kernel sources and the versions that turn them into code."""
    digest = hashlib.sha256()
    root = Path(__file__).resolve().parent.parent
    for package in KERNEL_PACKAGES:
        for source in sorted((root / package).glob("*.py")):
            digest.update(f"{package}/{source.name}\0".encode())
            digest.update(source.read_bytes())
    for library in ("numba", "llvmlite", "numpy"):
        digest.update(f"\0{library} {importlib.metadata.version(library)}".encode())
    return digest.hexdigest()[:16]


def use_kernel_cache(folder: Path) -> Path:
    """Keep compiled code under `folder`, in a subfolder named by `kernel_digest`; return that.

    Call it once per process, before the first world is made; a function compiled earlier stays as
    it is. The folder is made if missing.

    Errors: OSError if the folder cannot be made or written to.
    """
    place = folder / kernel_digest()
    place.mkdir(parents=True, exist_ok=True)
    probe = place / ".writable"
    probe.touch()
    numba.config.CACHE_DIR = str(place)  # type: ignore[attr-defined]
    _folder[:] = [place]
    for dispatcher in _kernels:
        dispatcher.enable_caching()
    return place
