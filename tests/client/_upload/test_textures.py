"""Textured shapes on the running service, and every snippet of their page."""

import io
import json
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import Any

import isomatch
import numpy as np
import pytest

from tests.solver.mesh.textures.textured_figures import textured_person, write_textured

PAGE = Path(__file__).resolve().parents[3] / "docs" / "textures.md"
BLOCKS = re.findall(r"(?ms)^```(\w+)\n(.*?)^```$", PAGE.read_text())
PYTHON = "\n".join(code for language, code in BLOCKS if language == "python")
COMMANDS = [line for language, code in BLOCKS if language == "sh" for line in code.splitlines()]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("textured")
    write_textured(folder)
    return folder


def run(command: list[str], folder: Path) -> str:
    done = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, timeout=240, check=False
    )
    assert done.returncode == 0, f"{command}\n{done.stderr}"
    return done.stdout


def assert_right(result: dict[str, Any]) -> None:
    """Matched points are on the same part of the person, and on the same side."""
    pairs = np.array([[one["source"], one["target"]] for one in result["correspondences"]])
    assert pairs.shape == (7, 2)
    here = textured_person("standing", 0).rest[pairs[:, 0] % 800]
    there = textured_person("walking", 1).rest[pairs[:, 1]]
    assert np.linalg.norm(here - there, axis=1).max() < 0.3
    assert np.linalg.norm(here * np.array([-1.0, 1.0, 1.0]) - there, axis=1).max() > 1.0


def test_the_commands_of_the_page(url: str, folder: Path) -> None:
    program = shutil.which("isomatch", path=str(Path(sys.executable).parent))
    assert program is not None
    assert [line.split()[1] for line in COMMANDS] == ["upload", "match"]
    for line in COMMANDS:
        run([program, *line.split()[1:]], folder)
    assert (folder / "match.png").read_bytes().startswith(b"\x89PNG")
    assert_right(json.loads((folder / "match.json").read_text()))


def test_the_python_of_the_page(url: str, folder: Path) -> None:
    program = "import warnings\nwarnings.simplefilter('error')\n" + PYTHON
    assert "True" in run([sys.executable, "-c", program], folder)


def test_warnings_of_missing_textures(client: isomatch.Client, folder: Path) -> None:
    walking = client.upload(folder / "walking.zip", name="a walk")
    assert (walking.has_colors, walking.file_type, walking.warnings) == (True, "zip", ())
    with zipfile.ZipFile(folder / "walking.zip") as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    lone = client.upload(files["scan/person.obj"], file_type="obj")
    assert not lone.has_colors
    assert "'skin.mtl', which is missing" in lone.warnings[0]
    with pytest.raises(isomatch.InvalidRequest, match="colours, which are missing in target"):
        client.match(walking, lone, points=7, descriptor="photometric").result()
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name in ("scan/person.obj", "scan/skin.mtl"):
            archive.writestr(name, files[name])
    with pytest.raises(isomatch.UnprocessableShape, match=r"'skin.png', which is not in the arch"):
        client.upload(stream.getvalue(), file_type="zip")
