"""``python -m worker``: run a worker until SIGTERM."""

import gc
import os
import signal
import sys
from typing import Final

ENVIRONMENT: Final = {
    # With GNU OpenMP, a parallel function run before a fork kills the forked job.
    "NUMBA_THREADING_LAYER": "workqueue",
    # Workers share the cores by being several.
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "MPLBACKEND": "Agg",
    # Threads of the library of object storage: each takes address space, of which a job has little.
    "TOKIO_WORKER_THREADS": "1",
}
"""Variables that the numerical libraries read when they are first imported."""


def main() -> int:
    """Set the environment, then import the libraries that read it."""
    # The first process of a container ignores signals without a handler; RQ sets its own later.
    signal.signal(signal.SIGTERM, _exit)
    for name, value in ENVIRONMENT.items():
        os.environ.setdefault(name, value)
    # Until the warm-up is over, nearly all objects are there to stay: searches only take time.
    gc.disable()
    from worker.process.process import main as run_worker

    return run_worker()


def _exit(number: int, frame: object) -> None:
    sys.exit(0)


if __name__ == "__main__":
    sys.exit(main())
