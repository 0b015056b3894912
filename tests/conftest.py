"""What every test may rely on: compiled code is kept between runs, under `var/kernels`."""

from pathlib import Path

from study.warehouse.kernels import use_kernel_cache

use_kernel_cache(Path(__file__).parent.parent / "var" / "kernels")
