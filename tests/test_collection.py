"""Every process finds the same tests: their names depend on no clock, order of a set, or chance."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent


def test_tests_have_the_same_names_in_every_process(request: pytest.FixtureRequest) -> None:
    # Options of whoever runs this one would change what is said of what is found.
    ours = {name: value for name, value in os.environ.items() if name != "PYTEST_ADDOPTS"}
    found = subprocess.run(
        [sys.executable, "-m", "pytest", "--collect-only", "-q", "-p", "no:cacheprovider"],
        cwd=ROOT,
        env=ours | {"PYTHONHASHSEED": "1"},
        capture_output=True,
        text=True,
        check=True,
    )
    later = set(found.stdout.splitlines())
    assert [item.nodeid for item in request.session.items if item.nodeid not in later] == []
