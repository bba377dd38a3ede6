"""What all tests share."""

import os

# Matrices in tests are small: threads of BLAS would only wait for one another.
for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

pytest_plugins = ["tests.stack"]
