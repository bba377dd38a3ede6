"""A container engine of its own for the checks: private socket, private images, ended by its id."""

import os
import shutil
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

PACKAGES = ("docker.io", "docker-compose", "debootstrap", "iptables")


class Engine:
    """A running engine.

    Parameters
    ----------
    folder
        Where its images, containers and its socket are.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.environment = {
            name: value
            for name, value in os.environ.items()
            if not name.startswith(("ISOMATCH_", "COMPOSE_", "DOCKER_"))
        } | {
            "DOCKER_HOST": f"unix://{folder}/docker.sock",
            "DOCKER_CONFIG": str(folder / "config"),
            "DOCKER_BUILDKIT": "1",
        }
        self.client = "docker"

    def docker(self, *arguments: str, seconds: float = 120, check: bool = True) -> str:
        """Run a command of the engine, and return what it says."""
        return self.run([self.client, *arguments], seconds, check=check)

    def run(
        self,
        command: list[str],
        seconds: float = 120,
        environment: dict[str, str] | None = None,
        check: bool = True,
    ) -> str:
        """Run a program against this engine, and return what it says."""
        done = subprocess.run(
            command,
            env=self.environment | (environment or {}),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=seconds,
            check=False,
        )
        assert not check or done.returncode == 0, f"{' '.join(command)}\n{done.stdout}"
        return done.stdout

    def composer(self) -> list[str]:
        """The command that is `docker compose` here: the plugin, or what came before it."""
        plugin = [self.client, "compose"]
        tried = subprocess.run(
            [*plugin, "version"], env=self.environment, capture_output=True, check=False
        )
        return plugin if tried.returncode == 0 else ["docker-compose"]


@contextmanager
def running_engine(folder: Path) -> Iterator[Engine]:
    """Install an engine if there is none, and run it for as long as a block of code lasts."""
    assert os.geteuid() == 0, "an engine of its own can only be started by root"
    _install()
    others = _engines()
    assert not others, f"another engine runs here (process {others}), and this one would disturb it"
    engine = Engine(folder)
    command = ["dockerd", "--host", engine.environment["DOCKER_HOST"]]
    for option, place in (
        ("data-root", "data"),
        ("exec-root", "exec"),
        ("pidfile", "dockerd.pid"),
    ):
        command += [f"--{option}", str(folder / place)]
    with (folder / "dockerd.log").open("ab") as log:
        process = subprocess.Popen(command, stdout=log, stderr=log, start_new_session=True)
    try:
        deadline = time.monotonic() + 60
        while "Server Version" not in engine.docker("info", check=False):
            assert process.poll() is None, (folder / "dockerd.log").read_text()[-2000:]
            assert time.monotonic() < deadline
            time.sleep(0.2)
        engine.client = _client(engine)
        # Compose calls it by its name.
        folders = [str(Path(engine.client).parent), *os.get_exec_path()]
        engine.environment["PATH"] = os.pathsep.join(folders)
        yield engine
    finally:
        process.terminate()
        process.wait(60)


def _client(engine: Engine) -> str:
    """The client that came with the engine, where there are several: others may lack parts."""
    version = "{{.Client.Version}} {{.Server.Version}}"
    for folder in os.get_exec_path():
        program = shutil.which("docker", path=folder)
        if program is not None:
            client, server = engine.run([program, "version", "--format", version]).split()
            if client == server:
                return program
    return shutil.which("docker") or "docker"


def _install() -> None:
    if shutil.which("dockerd") and shutil.which("debootstrap") and shutil.which("docker"):
        return
    apt = ["apt-get", "--quiet", "--yes"]
    quiet = os.environ | {"DEBIAN_FRONTEND": "noninteractive"}
    subprocess.run([*apt, "update"], env=quiet, check=True)
    subprocess.run([*apt, "install", "--no-install-recommends", *PACKAGES], env=quiet, check=True)
    if Path("/run/systemd/system").exists():
        # Its packages start an engine for the whole machine, which nobody has asked for.
        subprocess.run(["systemctl", "stop", "docker.socket", "docker.service"], check=False)


def _engines() -> list[int]:
    found = []
    for name in Path("/proc").glob("[0-9]*/comm"):
        try:
            if name.read_text().strip() == "dockerd":
                found.append(int(name.parent.name))
        except OSError:
            continue
    return found
