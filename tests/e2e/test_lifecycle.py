"""Start and stop of the stack and of the demo."""

import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import isomatch
import pytest

from demo.stack import ROOT, StackError, running_stack
from tests.processes import alive, descendants
from tests.waiting import until

linux = pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="reads /proc")


def test_a_service_that_cannot_start_says_why() -> None:
    with (
        pytest.raises(StackError, match="ended with code"),
        running_stack({"ISOMATCH_DATA_DIR": "/dev/null/data"}),
    ):
        pass


def demo(output: Path, folder: Path) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "demo", "--output", str(output), "--vertices", "1500"],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def test_the_demo(tmp_path: Path) -> None:
    output = tmp_path / "made" / "here"
    with demo(output, tmp_path) as process:
        said, progress = process.communicate(timeout=500)
    assert process.returncode == 0, said + progress
    for word in ("source", "distortion", "gap", "coarse level", "mean error", "What next"):
        assert word in said
    assert re.search(r"100%  match \w+: succeeded", progress)
    assert {path.name for path in output.iterdir()} == {
        "standing.off",
        "walking.off",
        "match.json",
        "match.png",
    }
    match = isomatch.Match.from_json((output / "match.json").read_bytes())
    assert len(match.pairs) == 32
    assert json.loads((output / "match.json").read_text())["certified"] is match.certified
    assert (output / "match.png").read_bytes().startswith(b"\x89PNG")


@linux
def test_an_interrupted_demo_leaves_no_process(tmp_path: Path) -> None:
    with demo(tmp_path, tmp_path) as process:
        until(lambda: len(descendants(process.pid)) >= 3, pause=0.05)
        family = descendants(process.pid)
        process.send_signal(signal.SIGINT)
        said, _ = process.communicate(timeout=500)
    assert process.returncode == 130, said
    assert "Interrupted" in said
    until(lambda: not alive(family), 120.0, pause=0.05)


def test_a_demo_that_cannot_write_says_so(tmp_path: Path) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("")
    with demo(blocked / "folder", tmp_path) as process:
        said, _ = process.communicate(timeout=500)
    assert process.returncode == 1
    assert "The demo failed" in said
