"""Stands in for a command of a document that is not run, and checks what can be checked of it."""

import os
import re
import subprocess
import sys
from itertools import takewhile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FILE = re.compile(r"(?:\./)?[\w.-]+(?:/[\w.-]+)+/?|[\w-]+\.(?:ya?ml|toml|md|py|txt|json)")
NOT_RUN = re.compile(r"demo$|service$|service\.admin$|worker$")
"""Modules that run for long, or change the store of a service."""


def main(name: str, arguments: list[str]) -> int:
    """Return 0 if the command could be run in a checkout."""
    # What is started from here is the real thing.
    here, *others = os.environ["PATH"].split(os.pathsep)
    assert Path(here).name == ".commands"
    os.environ["PATH"] = os.pathsep.join(others)
    if name == "make":
        # The targets and their recipes are there; nothing is made.
        return subprocess.call(["make", "-n", "-C", str(ROOT), *arguments])
    if name == "python" and not (arguments[:1] == ["-m"] and NOT_RUN.match(arguments[1])):
        return subprocess.call([sys.executable, *arguments])
    if name == "python":
        options = [word for word in arguments[2:] if word.startswith("-")]
        # Actions have options of their own.
        actions = list(takewhile(lambda word: not word.startswith("-"), arguments[2:]))
        said = subprocess.run(
            [sys.executable, *arguments[:2], *actions, "--help"],
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        missing = [option for option in options if option.partition("=")[0] not in said]
        return complain(f"{arguments[1]} has no {missing}") if missing else 0
    named = [word for word in arguments if FILE.fullmatch(word) and ":" not in word]
    gone = [word for word in named if not (ROOT / word).exists() and not Path(word).exists()]
    return complain(f"{name} names what is not there: {gone}") if gone else 0


def complain(message: str) -> int:
    """Say why the command could not be run."""
    print(message, file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2:]))
