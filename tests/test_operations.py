"""The operations guide says of every setting what is so, and names nothing that is not there."""

import os
import re
import subprocess
from pathlib import Path

import pytest

from service.settings import Settings
from tests.containers.manifests import COMPOSE, DOCKER
from worker.settings import WorkerSettings

ROOT = Path(__file__).resolve().parents[1]
GUIDE = (ROOT / "docs" / "operations.md").read_text()
ROWS = dict(re.findall(r"(?m)^\| `(ISOMATCH_\w+)` \| (.*) \|$", GUIDE.split("## Settings")[1]))


def shown(value: object) -> str:
    """A default as the table has it."""
    if value is None or value == ():
        return "unset"
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    return f"`{value}`"


def row(name: str) -> str:
    """What the table has to say of a setting: who reads it, its default, what it is."""
    api, worker = Settings.model_fields.get(name), WorkerSettings.model_fields.get(name)
    field = api or worker
    assert field is not None
    who = "both" if api and worker else "API" if api else "workers"
    # What both read means one thing.
    assert not (api and worker) or api.default == worker.default
    return f"{who} | {shown(field.default)} | {field.description}"


NAMES = sorted({*Settings.model_fields, *WorkerSettings.model_fields})


@pytest.mark.parametrize("name", NAMES)
def test_the_table_has_every_setting_as_it_is(name: str) -> None:
    assert ROWS[f"ISOMATCH_{name.upper()}"] == row(name)


def test_the_table_has_no_others() -> None:
    assert len(ROWS) == len(NAMES)


def test_whatever_is_named_is_there() -> None:
    known = {f"ISOMATCH_{name.upper()}" for name in NAMES}
    known |= set(re.findall(r"ISOMATCH_\w+", COMPOSE.read_text()))
    known |= set(re.findall(r"ISOMATCH_\w+", (DOCKER / "compose.remote.yaml").read_text()))
    assert set(re.findall(r"ISOMATCH_\w+", GUIDE)) <= known
    for metric in set(re.findall(r"isomatch_[a-z_]+", GUIDE)):
        base = re.sub(r"_(total|bucket)$", "", metric)
        assert any(f'"{base}"' in file.read_text() for file in (ROOT / "service").rglob("*.py"))
    for place in re.findall(r"`((?:docker|tests|worker)/[\w./-]+)`", GUIDE):
        assert place == "docker/.env" or (ROOT / place).exists(), place
    for target in re.findall(r"\]\(([^)#]+)", GUIDE):
        assert (ROOT / "docs" / target).exists(), target
    for variable, default in re.findall(r"`(ISOMATCH_\w+)` \(`?([\w.:]+)`?\)", GUIDE):
        if variable.startswith("ISOMATCH_JOB"):
            continue
        assert f"${{{variable}:-{default}}}" in COMPOSE.read_text(), variable


@pytest.mark.skipif(not (ROOT / ".git").exists(), reason="needs a checkout")
@pytest.mark.parametrize("name", ["docker/.env", "pip.conf", "queue.tar", "blobs.tar"])
def test_secrets_and_data_that_it_has_one_write_are_not_committed(name: str) -> None:
    assert name in GUIDE
    ignored = subprocess.run(["git", "check-ignore", "--quiet", name], cwd=ROOT, check=False)
    assert ignored.returncode == 0


def test_a_backup_that_fails_leaves_rewriting_switched_on(tmp_path: Path) -> None:
    docker = tmp_path / "docker"
    docker.write_text('#!/bin/sh\necho "$*" >> asked\n! echo "$*" | grep -q appendonlydir\n')
    docker.chmod(0o755)
    (commands,) = re.findall(r"(?ms)^### Backup$.*?^```sh\n(.*?)^```$", GUIDE)
    path = f"{tmp_path}:{os.environ['PATH']}"
    for shell in ("sh", "bash"):
        (tmp_path / "asked").unlink(missing_ok=True)
        script = [shell, "-e", "-c", commands]
        done = subprocess.run(script, cwd=tmp_path, env={"PATH": path}, check=False)
        assert done.returncode
        _, copy, last = (tmp_path / "asked").read_text().splitlines()
        assert "appendonlydir" in copy
        assert last.endswith("config set auto-aof-rewrite-percentage 100")
