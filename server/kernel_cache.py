"""Where compiled code is kept when a command runs without the server's folder."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from study.warehouse.kernels import use_kernel_cache


def open_kernel_cache() -> Path:
    """Use `VARIL_CACHE_DIR`, else `~/.cache/varil`, else, if neither can be written, a temp folder.

    Returns the folder of this version's code. Call it before the first world is made.
    """
    chosen = os.environ.get("VARIL_CACHE_DIR")
    folder = Path(chosen) if chosen else Path("~/.cache/varil").expanduser()
    try:
        return use_kernel_cache(folder)
    except (OSError, RuntimeError):
        owner = os.getuid() if hasattr(os, "getuid") else 0
        return use_kernel_cache(Path(tempfile.gettempdir()) / f"varil-kernels-{owner}")
