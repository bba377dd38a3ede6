"""Logs are JSON, one object per line."""

import json
import subprocess
import sys


def test_warnings_of_libraries_are_logged() -> None:
    script = (
        "import warnings; from broker.telemetry import configure_logging;"
        " configure_logging(process='api'); warnings.warn('deprecated', DeprecationWarning)"
    )
    command = [sys.executable, "-W", "always", "-c", script]
    said = subprocess.run(command, capture_output=True, text=True, check=True).stderr
    (line,) = said.splitlines()
    assert "deprecated" in json.loads(line)["event"]
