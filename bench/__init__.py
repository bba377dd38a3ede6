"""Experiments and benchmarks: ``python -m bench.NAME [--data DIR] [--json]`` from the root."""

import os

# One thread of linear algebra, as in a worker: ratios then hold on any number of cores. It has to
# be said before NumPy is first imported.
for _library in ("OPENBLAS", "MKL", "OMP"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")
