"""Workers start warm: forks of theirs neither compile nor load what most jobs need."""

import json
import os
import subprocess
import sys

from worker.__main__ import ENVIRONMENT


def test_jobs_compile_no_kernel_after_the_warm_up() -> None:
    """In a process of its own, because other tests have compiled kernels in this one."""
    done = subprocess.run(
        [sys.executable, "-m", "tests.worker.process.warm_start"],
        env={**os.environ, **ENVIRONMENT},
        capture_output=True,
        text=True,
        check=True,
    )
    said = json.loads(done.stdout.splitlines()[-1])
    assert said["kernels"] > 50
    assert said["late"] == []
