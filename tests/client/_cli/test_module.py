"""``python -m isomatch``."""

import subprocess
import sys

import isomatch


def test_the_package_is_the_command_line() -> None:
    command = [sys.executable, "-m", "isomatch", "--version"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=240, check=False)
    assert (done.returncode, done.stdout) == (0, f"isomatch {isomatch.__version__}\n"), done.stderr
