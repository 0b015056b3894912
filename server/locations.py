"""Where the files that are not Python lie: the web folder and the migrations.

In a checkout they stand beside `server/`; in an installed wheel they lie inside it.
"""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).parent


def web_root() -> Path:
    """The folder with `static/` and `templates/`."""
    return _beside("web", "_web")


def migrations_root() -> Path:
    """The folder with Alembic's `env.py` and `versions/`."""
    return _beside("migrations", "_migrations")


def _beside(in_checkout: str, in_wheel: str) -> Path:
    packed = _PACKAGE / in_wheel
    return packed if packed.is_dir() else _PACKAGE.parent / in_checkout
