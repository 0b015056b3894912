"""Compiles the world into the folder that the suite shares, before several processes want it."""

from __future__ import annotations

from server.live.compiling import choose_cache, load_kernels
from tests.conftest import KERNELS

if __name__ == "__main__":
    load_kernels(choose_cache(KERNELS))
