"""Every snippet of the client's README runs, in order, against the running service."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.client.shapes import write_blobs

README = Path(__file__).resolve().parents[2] / "client" / "README.md"
BLOCKS = re.findall(r"(?ms)^```(\w+)\n(.*?)^```$", README.read_text())
PYTHON = "\n".join(code for language, code in BLOCKS if language == "python")
COMMANDS = [
    line
    for language, code in BLOCKS
    if language == "sh"
    for line in code.splitlines()
    if line.startswith("isomatch ")
]


def test_there_is_something_to_try() -> None:
    assert {language for language, _ in BLOCKS} == {"python", "sh"}
    assert len(COMMANDS) >= 5


def test_python(url: str, tmp_path: Path) -> None:
    write_blobs(tmp_path)
    program = "import warnings\nwarnings.simplefilter('error')\n" + PYTHON
    done = subprocess.run(
        [sys.executable, "-c", program],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "match.png").read_bytes().startswith(b"\x89PNG")
    for said in ("points: ", "body.points", "urn:isomatch:problem:", "cancelled"):
        assert said in done.stdout


def test_commands(url: str, tmp_path: Path) -> None:
    write_blobs(tmp_path)
    program = shutil.which("isomatch", path=str(Path(sys.executable).parent))
    if program is None:
        pytest.fail("the command `isomatch` is not installed beside this Python")
    for command in COMMANDS:
        done = subprocess.run(
            [program, *command.split()[1:]],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )
        assert done.returncode == 0, f"{command}\n{done.stderr}"
    assert (tmp_path / "match.json").exists()
