"""What all tests share."""

import gc
import os
import signal
from collections.abc import Generator

import pytest
from hypothesis import HealthCheck, settings

# Matrices in tests are small: threads of BLAS would only wait for one another.
for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

# Shells start programs in the background with Ctrl-C ignored, which those that tests start inherit.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# An example may take as long as it does on a busy machine, or while kernels are compiled. Every run
# draws the same examples; `--hypothesis-profile chance` draws others.
ANY_MACHINE = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("chance", ANY_MACHINE)
settings.register_profile("any machine", ANY_MACHINE, derandomize=True, database=None)
settings.load_profile("any machine")

pytest_plugins = [
    "tests.blobs",
    "tests.object_storage",
    "tests.scheduling",
    "tests.stack",
    "tests.workers",
]


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Keep all that is imported: half the time of a collection went into looking for garbage."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()
        gc.freeze()
