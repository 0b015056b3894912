"""Where compiled code is kept between processes, and what makes it outdated."""

from __future__ import annotations

import hashlib
import importlib.metadata
import os
import tempfile
from pathlib import Path

import study


def kernel_folder() -> Path:
    """`VARIL_CACHE_DIR`, or `~/.cache/varil` if it is not set."""
    chosen = os.environ.get("VARIL_CACHE_DIR")
    return Path(chosen) if chosen else Path("~/.cache/varil").expanduser()


def open_kernel_cache() -> Path:
    """Use the kernel folder, or a temporary one where it cannot be written.

    Returns the folder of this version's code. Call it before the first world is made.
    """
    try:
        return use_kernel_cache(kernel_folder())
    except (OSError, RuntimeError):
        owner = os.getuid() if hasattr(os, "getuid") else 0
        return use_kernel_cache(Path(tempfile.gettempdir()) / f"varil-kernels-{owner}")


def use_kernel_cache(folder: Path) -> Path:
    """Keep compiled code under `folder`, in a subfolder named by `kernel_digest`; return that.

    Raises OSError if the folder cannot be made or written to.
    """
    from study.warehouse.kernels import keep_compiled_code  # loads the compiler

    place = folder / kernel_digest()
    place.mkdir(parents=True, exist_ok=True)
    (place / ".writable").touch()
    keep_compiled_code(str(place))
    return place


def kernel_digest() -> str:
    """16 hex digits over all kernel sources and the versions that turn them into code."""
    from study.warehouse.kernels import KERNEL_PACKAGES

    digest = hashlib.sha256()
    root = Path(study.__file__).parent
    for package in KERNEL_PACKAGES:
        for source in sorted((root / package).glob("*.py")):
            digest.update(f"{package}/{source.name}\0".encode())
            digest.update(source.read_bytes())
    for library in ("numba", "llvmlite", "numpy"):
        digest.update(f"\0{library} {importlib.metadata.version(library)}".encode())
    return digest.hexdigest()[:16]
