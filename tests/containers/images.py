"""The images that the checks run: those others make, or stand-ins for them, and ours."""

import os
import re
import shutil
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

from packaging.requirements import Requirement

from service.standalone import server_binary
from tests.containers.engine import Engine
from tests.containers.manifests import DOCKER, ROOT, compose

PYTHON = "python:3.11-slim-bookworm"
STORE: str = compose()["services"]["queue"]["image"]

_STORE_STAND_IN = f"""
FROM {PYTHON}
COPY valkey-server /usr/local/bin/
RUN ln -s /usr/bin/redis-cli /usr/local/bin/valkey-cli \
 && groupadd --gid 999 valkey && useradd --uid 999 --gid 999 valkey \
 && install --directory --owner 999 --group 999 /data
VOLUME /data
WORKDIR /data
"""


def provide_bases(engine: Engine) -> None:
    """Get the images that ours begin with: from their registry, or as stand-ins of Debian's."""
    for image in (PYTHON, STORE):
        if engine.docker("images", "--quiet", image).strip():
            continue
        try:
            engine.docker("pull", "--quiet", image, seconds=60)
        except (AssertionError, subprocess.TimeoutExpired):
            print(f"no registry has {image} for us: made of Debian's packages")
            (_python if image == PYTHON else _store)(engine)


def build(engine: Engine) -> None:
    """Build both images."""
    version = engine.docker("run", "--rm", PYTHON, "python", "--version").split()[1]
    wheels = engine.folder / "wheels"
    for lock in ("service.txt", "worker.txt"):
        _download(ROOT / "requirements" / lock, version, wheels)
    with _index(wheels) as address:
        settings = engine.folder / "pip.conf"
        settings.write_text(f"[global]\nno-index = true\nfind-links = {address}\n")
        for target in ("api", "worker"):
            command = ["build", "--network", "host", "--secret", f"id=pip,src={settings}"]
            command += ["--target", target, "--tag", f"isomatch-{target}"]
            engine.docker(*command, "--file", str(DOCKER / "Dockerfile"), str(ROOT), seconds=1500)


def _python(engine: Engine) -> None:
    root = engine.folder / "root"
    if not root.exists():
        half = engine.folder / "root.half"
        shutil.rmtree(half, ignore_errors=True)
        packages = "python3,python3-venv,ca-certificates,redis-tools"
        command = ["debootstrap", "--variant=minbase", f"--include={packages}", "bookworm"]
        engine.run([*command, str(half)], seconds=900)
        (half / "usr/bin/python").symlink_to("python3")
        for left in ("var/cache/apt/archives", "var/lib/apt/lists"):
            shutil.rmtree(half / left)
        half.rename(root)
    engine.run(["sh", "-c", f"tar -C '{root}' -c . | '{engine.client}' import - {PYTHON}"], 300)


def _store(engine: Engine) -> None:
    folder = engine.folder / "store"
    folder.mkdir(exist_ok=True)
    shutil.copy(server_binary(), folder / "valkey-server")
    (folder / "Dockerfile").write_text(_STORE_STAND_IN)
    engine.docker("build", "--tag", STORE, str(folder), seconds=300)


def _download(lock: Path, python: str, wheels: Path) -> None:
    """Download what a lock file names for another Python than this one, as pip is set up here."""
    wanted = []
    for entry in re.split(r"\n(?=\S)", lock.read_text()):
        head, _, hashes = entry.partition(" \\\n")
        if not head or head.startswith("#"):
            continue
        requirement = Requirement(head)
        there = {"python_full_version": python, "python_version": python.rpartition(".")[0]}
        if requirement.marker is None or requirement.marker.evaluate(there):
            wanted.append(f"{requirement.name}{requirement.specifier} \\\n{hashes}")
    wheels.mkdir(exist_ok=True)
    listed = wheels.with_name(lock.name)
    listed.write_text("\n".join(wanted))
    command = [sys.executable, "-m", "pip", "download", "--no-deps", "--require-hashes"]
    command += ["--only-binary", ":all:", "--requirement", str(listed), "--dest", str(wheels)]
    # What pip warns of concerns its settings here, and not the images.
    subprocess.run(command, env=os.environ | {"PIP_QUIET": "2"}, check=True)


@contextmanager
def _index(wheels: Path) -> Iterator[str]:
    handler = partial(_Quiet, directory=str(wheels))
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield f"http://127.0.0.1:{server.server_address[1]}/"
        server.shutdown()
        thread.join()


class _Quiet(SimpleHTTPRequestHandler):
    def log_message(self, format: str, *arguments: object) -> None:  # noqa: A002
        """Say nothing of each file."""
