"""``python -m worker``: run a worker until it is told to stop."""

import os
import signal
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
    # The first process of a container ignores what it has no handler for; RQ's come later.
    signal.signal(signal.SIGTERM, _leave)
    for name, value in ENVIRONMENT.items():
        os.environ.setdefault(name, value)
    from worker.process.process import main as run_worker

    return run_worker()


def _leave(number: int, frame: object) -> None:
    sys.exit(0)


if __name__ == "__main__":
    sys.exit(main())
