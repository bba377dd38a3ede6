"""The code blocks of the documents, and how they are run."""

import json
import os
import re
import shlex
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from demo.stack import ROOT

SERVED = "http://127.0.0.1:8000"
"""Where the documents say the service listens."""

ARROW = re.compile(r"\s# → (?P<answer>\{.*)$", re.MULTILINE)
PLACEHOLDER = re.compile(r"[0-9a-f]+…")

PATIENCE = 300.0
KEEP = "export -p | grep -v '^declare -[a-z]*r' > .variables"
STAND_INS = ("make", "python", "pip", "docker", "kubectl", "helm", "redis-cli", "st", "git")


@dataclass(frozen=True)
class Block:
    """A code block: its language, the line it begins at, what it says."""

    language: str
    line: int
    code: str


def blocks(document: Path) -> list[Block]:
    """All code blocks of a document, in order."""
    text = document.read_text()
    found = re.finditer(r"(?ms)^ *```(\w*)\n(.*?)^ *```$", text)
    return [
        Block(match.group(1), text.count("\n", 0, match.start()) + 2, match.group(2))
        for match in found
    ]


def statements(code: str) -> Iterator[str]:
    """The commands of a shell script, each as long as bash takes it to be."""
    lines: list[str] = []
    for line in code.splitlines():
        lines.append(line)
        text = "\n".join(lines)
        if not text.strip() or text.rstrip().endswith("\\"):
            continue
        checked = subprocess.run(["bash", "-n", "-c", text], capture_output=True, check=False)
        if checked.returncode == 0 and not checked.stderr:
            yield text
            lines = []
    assert not "".join(lines).strip(), "\n".join(lines)


@dataclass
class Terminal:
    """A folder in which commands are run one after the other, as a reader types them.

    Variables are kept from one to the next. What would change the machine or run for minutes is
    replaced by stand-ins (:mod:`tests.docs.stand_in`), which check what they are asked for.

    Attributes
    ----------
    folder
        Where they run; ``.venv`` stands for the environment that `make` makes.
    url
        Where the service listens in truth.
    names
        What stands for ids in the document, and the ids.
    """

    folder: Path
    url: str
    names: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        commands, real = self.folder / ".commands", Path(sys.prefix, "bin")
        # What documents call .venv/bin has the same stand-ins.
        environment = self.folder / ".venv" / "bin"
        for folder in (commands, environment):
            folder.mkdir(parents=True)
        (environment / "isomatch").symlink_to(real / "isomatch")
        stand_in = Path(__file__).with_name("stand_in.py")
        for name in STAND_INS:
            script = commands / name
            arguments = shlex.join([sys.executable, str(stand_in), name])
            script.write_text(f'#!/bin/sh\nexec {arguments} "$@"\n')
            script.chmod(0o755)
            (environment / name).symlink_to(script)
        (self.folder / ".variables").touch()
        self.environment = {
            **os.environ,
            "PATH": f"{commands}:{real}:{os.environ['PATH']}",
            "ISOMATCH_URL": self.url,
            "PYTHONPATH": str(ROOT),
            "MPLBACKEND": "Agg",
        }

    def run(self, statement: str) -> str:
        """Run a command, and return what it prints; learn the ids that a comment gives names."""
        for name in set(PLACEHOLDER.findall(ARROW.sub("", statement))):
            assert name in self.names, f"nothing said what {name} is: {statement}"
        ready = PLACEHOLDER.sub(lambda found: self.names.get(found.group(), ""), statement)
        program = f". ./.variables\n{ready.replace(SERVED, self.url)}\n{KEEP}"
        with subprocess.Popen(
            ["bash", "-aeuo", "pipefail", "-c", program],
            cwd=self.folder,
            env=self.environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        ) as process:
            try:
                said, complaints = process.communicate(timeout=PATIENCE)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)
                raise
        assert process.returncode == 0, f"{statement}\n{said}{complaints}"
        if (promised := ARROW.search(statement)) is not None:
            self._learn(promised.group("answer"), said)
        return said

    def _learn(self, promised: str, said: str) -> None:
        answer = json.loads(said)
        named = re.findall(r'"(\w+)"(?:: "([0-9a-f]+…)")?', promised)
        assert named, promised
        for key, name in named:
            assert key in answer, f"{promised}\n{said}"
            if name:
                self.names[name] = answer[key]
