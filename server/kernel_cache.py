"""Where compiled code is kept between processes."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path


def kernel_folder() -> Path:
    """`VARIL_CACHE_DIR`, or `~/.cache/varil` if it is not set."""
    chosen = os.environ.get("VARIL_CACHE_DIR")
    return Path(chosen) if chosen else Path("~/.cache/varil").expanduser()


def open_kernel_cache() -> Path:
    """Use the kernel folder, or a temporary one where it cannot be written.

    Returns the folder of this version's code. Call it before the first world is made.
    """
    from study.warehouse.kernels import use_kernel_cache  # loads the compiler

    try:
        return use_kernel_cache(kernel_folder())
    except (OSError, RuntimeError):
        owner = os.getuid() if hasattr(os, "getuid") else 0
        return use_kernel_cache(Path(tempfile.gettempdir()) / f"varil-kernels-{owner}")
