"""The images, built and run for real: ``make test-containers``, as root; not in ``make test``.

An engine of its own is started on a private socket, and installed on Debian where there is none.
Where the registries of the images that ours begin with cannot be reached, stand-ins are made of
Debian's packages. ``ISOMATCH_CONTAINERS_DIR`` names a folder to keep what was built.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from tests.containers.engine import Engine, running_engine
from tests.containers.images import build, provide_bases
from tests.containers.installation import PASSWORD, PORT, SETTINGS, Installation
from tests.containers.manifests import ROOT
from tests.docs.blocks import statements
from tests.requests import ask, upload
from tests.waiting import until
from tests.worker.figures import blob_file

LONG: dict[str, Any] = {"points": 96, "alternatives": 16}
QUICK: dict[str, Any] = {"points": 8, "eigenpairs": 30}

RECOVERY = 60.0
"""Seconds within which what was lost has to go on."""


@pytest.fixture(scope="module")
def engine() -> Iterator[Engine]:
    kept = os.environ.get("ISOMATCH_CONTAINERS_DIR")
    folder = Path(kept).resolve() if kept else Path(tempfile.mkdtemp(prefix="isomatch-containers-"))
    folder.mkdir(parents=True, exist_ok=True)
    with running_engine(folder) as running:
        yield running
    if kept is None:
        shutil.rmtree(folder)


@pytest.fixture(scope="module")
def images(engine: Engine) -> Engine:
    provide_bases(engine)
    build(engine)
    return engine


@pytest.fixture(scope="module")
def service(images: Engine) -> Iterator[Installation]:
    installation = Installation(images)
    installation.up()
    yield installation
    installation.compose("kill")
    installation.compose("down", "--volumes", seconds=120)
    installation.http.close()


@pytest.fixture(scope="module")
def shape(service: Installation) -> str:
    return upload(service.http, blob_file(4))


def run_docs(service: Installation, title: str, folder: Path) -> None:
    """Run the commands that a section of the operations guide gives, in order."""
    text = (ROOT / "docs" / "operations.md").read_text()
    section = text.split(f"\n{title}\n", 1)[1].split("\n#", 1)[0]
    commands = "\n".join(re.findall(r"(?ms)^```sh\n(.*?)^```$", section))
    assert "docker compose" in commands
    for statement in statements(commands):
        service.shell(statement, folder)


def test_images(images: Engine) -> None:
    for target in ("api", "worker"):
        about = json.loads(images.docker("inspect", f"isomatch-{target}"))[0]
        assert about["Config"]["User"] == "10001:10001"
        assert about["Config"]["Healthcheck"]["Test"][0] == "CMD"
        print(target, round(about["Size"] / 1e6), "MB")
        inside = ["run", "--rm", "--read-only", "--entrypoint", "python", f"isomatch-{target}"]
        said = images.docker(
            *inside,
            "-c",
            "import importlib.util as u, os\n"
            "names = 'pip', 'numpy', 'solver', 'fastapi'\n"
            "print(*[name for name in names if u.find_spec(name)])\n"
            "print(os.path.exists('/etc/pip.conf') and open('/etc/pip.conf').read())",
        )
        found, settings = said.splitlines()
        assert found.split() == (["fastapi"] if target == "api" else ["numpy", "solver"])
        assert settings in ("False", ""), "the address of the index stays outside"
        assert "find-links" not in images.docker("history", "--no-trunc", f"isomatch-{target}")


def test_kernels_are_compiled_already(images: Engine) -> None:
    confined = ["run", "--rm", "--read-only", "--cap-drop", "ALL", "--tmpfs", "/tmp:size=256m"]
    said = images.docker(*confined, "isomatch-worker", "--warm-up")
    lines = [json.loads(line) for line in said.splitlines()]
    seconds = [line["seconds"] for line in lines if "seconds" in line]
    print("warm after", seconds)
    assert len(seconds) == 2
    assert sum(seconds) < 20, "to compile them takes longer than half a minute"


def test_containers_are_confined(service: Installation) -> None:
    for name, user in (("api", "10001"), ("worker", "10001"), ("queue", "999"), ("cache", "999")):
        for container in service.containers(name):
            host = service.inspect(container)["HostConfig"]
            assert host["ReadonlyRootfs"] is True
            assert host["CapDrop"] == ["ALL"]
            assert "no-new-privileges:true" in host["SecurityOpt"]
            assert host["Memory"] > 0
            script = "id -u; touch /here 2>&1 || true; grep -h CapEff /proc/self/status"
            said = service.engine.docker("exec", container, "sh", "-c", script).splitlines()
            assert said[0] == user
            assert "Read-only file system" in said[1]
            assert said[2].split() == ["CapEff:", "0000000000000000"]
    (api,) = service.containers("api")
    ports = service.inspect(api)["HostConfig"]["PortBindings"]
    assert ports == {"8000/tcp": [{"HostIp": "127.0.0.1", "HostPort": str(PORT)}]}
    for store in ("queue", "cache"):
        (container,) = service.containers(store)
        assert not service.inspect(container)["HostConfig"]["PortBindings"]


def test_health_checks(service: Installation) -> None:
    for name in ("api", "worker", "queue", "cache"):
        for container in service.containers(name):
            until(partial(service.healthy, container), 90, pause=0.1)


def test_a_match(service: Installation) -> None:
    source, target = upload(service.http, blob_file(3)), upload(service.http, blob_file(3, seed=1))
    result = service.result(ask(service.http, source, target, points=16))
    pairs = [(pair["source"], pair["target"]) for pair in result["correspondences"]]
    assert len(pairs) == 16
    # The target is the source, turned and moved: vertices correspond to themselves.
    assert sum(one == other for one, other in pairs) >= 14
    assert result["certified"]


def test_a_worker_is_killed(service: Installation, shape: str) -> None:
    undisturbed = service.result(ask(service.http, shape, **LONG))
    job, waiting = ask(service.http, shape, **LONG), ask(service.http, shape, **QUICK)
    victim = service.until_begun(job)
    service.engine.docker("kill", victim)
    start = time.monotonic()
    until(lambda: service.began(job) != [], RECOVERY, pause=0.1)
    print("taken over after", round(time.monotonic() - start, 1), "s")
    assert service.result(job)["correspondences"] == undisturbed["correspondences"]
    service.result(waiting)
    service.up()


def test_a_worker_is_stopped(service: Installation, shape: str) -> None:
    job = ask(service.http, shape, **LONG)
    leaving = service.until_begun(job)
    with ThreadPoolExecutor(1) as threads:
        stopped = threads.submit(service.engine.docker, "stop", "--time", "120", leaving)
        service.result(job)
        stopped.result()
    said = service.said(leaving)
    assert ("done", job) in said, "it ended its job before it left"
    assert service.inspect(leaving)["State"]["ExitCode"] == 0
    assert service.began(job) == [], "nobody else had to"
    service.up()


def test_a_worker_that_warms_up_is_stopped_at_once(images: Engine) -> None:
    stores = ["ISOMATCH_REDIS_URL=redis://127.0.0.1:1", "ISOMATCH_BLOB_URL=file:///blobs"]
    where = [*(part for store in stores for part in ("--env", store)), "--tmpfs", "/tmp"]
    container = images.docker("run", "--detach", "--read-only", *where, "isomatch-worker").strip()
    try:
        time.sleep(4)
        start = time.monotonic()
        images.docker("stop", "--time", "30", container)
        assert time.monotonic() - start < 20
        state = json.loads(images.docker("inspect", container))[0]["State"]
        assert state["ExitCode"] == 0, images.docker("logs", container)
    finally:
        images.docker("rm", "--force", container)


def test_the_cache_is_restarted(service: Installation, shape: str) -> None:
    expected = service.result(ask(service.http, shape, **QUICK))
    before = service.spectra_computed()
    job = ask(service.http, shape, **LONG)
    service.until_begun(job)
    service.compose("restart", "cache")
    service.result(job)
    again = service.result(ask(service.http, shape, **QUICK))
    assert again["correspondences"] == expected["correspondences"]
    assert service.spectra_computed() > before, "it was computed again"


def test_the_queue_is_killed(service: Installation, shape: str) -> None:
    jobs = [ask(service.http, shape, **LONG), ask(service.http, shape, **QUICK)]
    service.until_begun(jobs[0])
    jobs += [ask(service.http, shape, points=12) for _ in range(4)]
    (queue,) = service.containers("queue")
    service.engine.docker("kill", queue)
    time.sleep(2)
    service.engine.docker("start", queue)
    for job in jobs:
        service.result(job)
    assert service.ready() >= 2


def test_the_api_is_stopped_and_started(service: Installation, shape: str) -> None:
    job = ask(service.http, shape, **LONG)
    (api,) = service.containers("api")
    service.engine.docker("stop", api)
    assert service.inspect(api)["State"]["ExitCode"] == 0, "it was killed after its grace"
    service.up()
    service.result(job)


def test_burst_workers_leave_by_themselves(service: Installation, shape: str) -> None:
    service.compose("stop", "worker")
    jobs = [ask(service.http, shape, points=points) for points in (8, 9, 10)]
    service.compose("run", "--rm", "-T", "worker", "--burst", seconds=180)
    for job in jobs:
        service.result(job)
    service.up()


def test_backup_and_restore(service: Installation, tmp_path: Path) -> None:
    shape = upload(service.http, blob_file(3))
    job = ask(service.http, shape, points=14)
    result = service.result(job)
    run_docs(service, "### Backup", tmp_path)
    assert (tmp_path / "queue.tar").stat().st_size > 10_000
    assert (tmp_path / "blobs.tar").stat().st_size > 10_000
    later = ask(service.http, shape, points=15)
    service.result(later)
    run_docs(service, "### Restore", tmp_path)
    until(lambda: service.ready() == 2, 120, pause=0.1)
    assert service.result(job)["correspondences"] == result["correspondences"]
    assert service.http.get(f"/v1/jobs/{later}").status_code == 404
    service.result(ask(service.http, shape, points=15))


def test_a_worker_of_another_machine_joins(service: Installation, shape: str) -> None:
    service.up(remote=True)
    service.compose("stop", "worker", remote=True)
    job = ask(service.http, shape, points=11)
    (volume,) = json.loads(service.engine.docker("volume", "inspect", "checks_blobs"))
    settings = {
        # As if this machine had mounted a file system of the other.
        "ISOMATCH_BLOB_URL": f"file://{volume['Mountpoint']}",
        "ISOMATCH_REDIS_URL": f"redis://:{PASSWORD}@127.0.0.1:6379/0",
        "ISOMATCH_CACHE_URL": f"redis://:{PASSWORD}@127.0.0.1:6380/0",
        "ISOMATCH_HEARTBEAT": SETTINGS["ISOMATCH_HEARTBEAT"],
    }
    subprocess.run(
        [sys.executable, "-m", "worker", "--burst"],
        cwd=ROOT,
        env=os.environ | settings,
        check=True,
        timeout=900,  # this machine may have to compile first, which its images do not
    )
    service.result(job)
