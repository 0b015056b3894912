"""The decorator of every compiled function.

A compiled function is cached on disk under its own source file only: a change in a function that it
calls, in another file, would go unseen and the old machine code would go on answering. So all code
lives in one folder named by a hash of *all* kernel sources and of the compiler's versions; without
such a folder, functions are compiled anew in each process.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

F = TypeVar("F", bound=Callable[..., Any])

KERNEL_PACKAGES = ("warehouse", "ar", "people")
"""The packages of `study` in which compiled functions may live: all their sources enter the hash.
"""

_kernels: list[Any] = []
_folder: list[str] = []


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


def keep_compiled_code(folder: str) -> None:
    """Load machine code from `folder` and store it there, from now on.

    Call it once per process, before the first world is made; a function compiled earlier stays as
    it is. The folder must hold code of these very sources only; `server.kernel_cache` sees to that.
    """
    numba.config.CACHE_DIR = folder  # type: ignore[attr-defined]
    _folder[:] = [folder]
    for dispatcher in _kernels:
        dispatcher.enable_caching()
