"""``python -m worker``: run a worker until it is told to stop."""

import os
import sys
from typing import Final

ENVIRONMENT: Final = {
    # A parallel function run before a fork kills the forked job with GNU OpenMP.
    "NUMBA_THREADING_LAYER": "workqueue",
    # Workers share the cores by being several.
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "MPLBACKEND": "Agg",
}
"""What the numerics read once, when they are first imported."""


def main() -> int:
    """Set the environment, and only then import what reads it."""
    for name, value in ENVIRONMENT.items():
        os.environ.setdefault(name, value)
    from worker.process import main as run_worker

    return run_worker()


if __name__ == "__main__":
    sys.exit(main())
