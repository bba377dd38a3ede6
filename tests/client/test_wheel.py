"""The distribution: built, installed where nothing else is, used with the running service."""

import email
import os
import re
import subprocess
import sys
import tarfile
import zipfile
from dataclasses import dataclass
from email.message import Message
from importlib.metadata import distributions
from pathlib import Path

import pytest
from markdown_it import MarkdownIt
from packaging.requirements import Requirement
from trove_classifiers import classifiers

from demo.stack import ROOT

SCRIPT = """
import asyncio
import sys

import isomatch
import numpy as np
import numpy.typing as npt
from typing import assert_type


def main(source: str, target: str) -> int:
    with isomatch.Client(retries=1) as client:
        first, second = client.upload(source), client.upload(target)
        assert_type(first, isomatch.Shape)
        job = client.match(first, second, points=6, coarse_points=6)
        assert_type(job, isomatch.Job[isomatch.Match])
        for told in job.events():
            assert_type(told.progress.fraction, float)
        match = job.result(progress=True)
        assert_type(match.pairs, npt.NDArray[np.int64])
        try:
            match.plot()
        except isomatch.MissingExtra as missing:
            print(missing)
        try:
            client.shape("0" * 32)
        except isomatch.NotFound as error:
            assert_type(error.problem.detail, str | None)
            print(error.status)
        with open(source, "rb") as file:
            again = client.upload(memoryview(file.read()), file_type="off")
        assert again.id == first.id
        metrics = ["commute_time", "geodesic"]
        choice: isomatch.StructureChoice = {"name": "hks", "times": [0.1, 0.3]}
        # The coarsest level alone: one of each.
        client.match(first, second, points=6, metric=metrics, descriptor=(choice, "none")).cancel()
        dense = client.match(first, second, points=6, coarse_points=6, dense=True).result()
        client.transfer(dense, what="landmarks", points=dense.pairs[:2, 0]).result()
        corners = np.array([[0, 1, 2]])
        client.delete_shape(client.upload((np.eye(3), corners, np.eye(3)), name="triangle"))
    return asyncio.run(once_more(first, second, len(match.pairs)))


async def once_more(first: isomatch.Shape, second: isomatch.Shape, count: int) -> int:
    async with isomatch.AsyncClient() as client:
        job = await client.match(first, second, points=count, coarse_points=6)
        assert_type(job, isomatch.AsyncJob[isomatch.Match])
        match = await job.result()
        assert_type(match, isomatch.Match)
        return len(match.costs)


if __name__ == "__main__":
    print(main(*sys.argv[1:]))
"""


@dataclass(frozen=True)
class Built:
    """Where the two distributions are."""

    wheel: Path
    sdist: Path


def build(project: Path, folder: Path, *targets: str) -> None:
    """Build without a network: what builds is installed here."""
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-d", str(folder), *targets],
        cwd=project,
        capture_output=True,
        check=True,
    )


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Built:
    folder = tmp_path_factory.mktemp("dist")
    build(ROOT / "client", folder)
    (wheel,), (sdist,) = folder.glob("*.whl"), folder.glob("*.tar.gz")
    return Built(wheel, sdist)


@pytest.fixture(scope="module")
def clean(built: Built, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Programs of an environment in which the wheel and what it asks for is all there is."""
    folder = tmp_path_factory.mktemp("clean")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder / "venv"], check=True)
    # The versions that everything else is tested with.
    pins = folder / "constraints.txt"
    installed = {found.name: found.version for found in distributions()}
    installed.pop("isomatch")
    pins.write_text("".join(f"{name}=={version}\n" for name, version in installed.items()))
    done = subprocess.run(
        [
            *(sys.executable, "-m", "pip", "--python", str(folder / "venv" / "bin" / "python")),
            *("install", "--quiet", "--no-compile", "--disable-pip-version-check"),
            *("--constraint", str(pins), str(built.wheel)),
        ],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return folder / "venv" / "bin"


def metadata(built: Built) -> Message:
    with zipfile.ZipFile(built.wheel) as wheel:
        (name,) = (name for name in wheel.namelist() if name.endswith(".dist-info/METADATA"))
        return email.message_from_bytes(wheel.read(name))


def contents(wheel: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(wheel) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def outside(folder: Path, *command: str | Path, **variables: str) -> str:
    """Run a program that knows nothing of this checkout; return what it says."""
    inherited = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}
    done = subprocess.run(
        list(map(str, command)),
        cwd=folder,
        env={**inherited, "NO_COLOR": "1", **variables},
        capture_output=True,
        text=True,
        timeout=240,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_the_metadata_is_complete(built: Built) -> None:
    told = metadata(built)
    assert told["License-Expression"] == "MIT"
    assert told["License-File"] == "LICENSE"
    assert told["Requires-Python"] == ">=3.11"
    assert {*told.get_all("Classifier", [])} <= classifiers
    assert "Typing :: Typed" in told.get_all("Classifier", [])
    needed = [Requirement(text) for text in told.get_all("Requires-Dist", [])]
    always = {found.name for found in needed if found.marker is None}
    assert always == {
        *("anyio", "httpx2", "numpy", "pydantic", "rich", "typer", "typing-extensions"),
    }
    assert {found.name for found in needed} - always == {"plotly", "mcp"}
    assert told.get_all("Provides-Extra") == ["mcp", "plot"]
    assert (ROOT / "client" / "LICENSE").read_text() == (ROOT / "LICENSE").read_text()


def test_the_readme_can_be_shown_by_an_index(built: Built) -> None:
    told = metadata(built)
    assert told["Description-Content-Type"] == "text/markdown"
    text = told.get_payload()
    assert isinstance(text, str)
    page = MarkdownIt("commonmark").enable("table").render(text)
    assert "<h1>isomatch" in page
    assert page.count("<pre>") == text.count("```") // 2
    # What is beside it in a checkout is not on the index.
    assert all(
        "://" in link or link[0] == "#" for link in re.findall(r'(?:href|src)="(.*?)"', page)
    )


def test_the_wheel_is_what_the_source_distribution_makes(built: Built, tmp_path: Path) -> None:
    with tarfile.open(built.sdist) as source:
        source.extractall(tmp_path, filter="data")
    (project,) = tmp_path.iterdir()
    build(project, tmp_path / "dist", "-t", "wheel")
    (again,) = (tmp_path / "dist").iterdir()
    ours = contents(built.wheel)
    assert contents(again) == ours
    assert "isomatch/py.typed" in ours
    client = ROOT / "client"
    files = [client / "isomatch_command.py", *(client / "isomatch").rglob("*.py")]
    modules = {str(path.relative_to(client)) for path in files}
    assert {name for name in ours if name.endswith(".py")} == modules


def test_the_wheel_works_with_its_dependencies_alone(
    url: str, clean: Path, blobs: tuple[Path, Path], tmp_path: Path
) -> None:
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    said = outside(tmp_path, clean / "python", "-W", "error", script, *blobs, ISOMATCH_URL=url)
    assert said.splitlines() == [
        "plotly is not installed: pip install 'isomatch[plot]'",
        "404",
        "6",
    ]
    names = "'solver', 'worker', 'service', 'trimesh', 'scipy', 'pytest'"
    program = f"import importlib.util as u; print(any(map(u.find_spec, [{names}])))"
    assert outside(tmp_path, clean / "python", "-c", program) == "False\n"

    quick = ["--points", "6", "--coarse-points", "6"]
    table = outside(tmp_path, clean / "isomatch", "match", *blobs, *quick, ISOMATCH_URL=url)
    assert "certified" in table


def test_a_users_script_is_type_checked_strictly(clean: Path, tmp_path: Path) -> None:
    (tmp_path / "script.py").write_text(SCRIPT)
    (tmp_path / "wrong.py").write_text("import isomatch\nisomatch.Client().upload(3)\n")
    strictly = ["-m", "mypy", "--strict", "--cache-dir", ".cache", "--config-file", os.devnull]
    python = ["--python-executable", str(clean / "python")]
    with pytest.raises(AssertionError, match=r'wrong\.py:2: .*incompatible type "int"') as told:
        outside(tmp_path, sys.executable, *strictly, *python, "script.py", "wrong.py")
    assert "Found 1 error in 1 file (checked 2 source files)" in str(told.value)
