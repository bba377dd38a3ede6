"""Commands of ``bench`` in the documents and the Makefile: the modules have these options."""

import re
from importlib import import_module

import pytest

from demo.stack import ROOT
from tests.docs.test_documents import DOCUMENTS

BLOCK = re.compile(r"^ *```.*?^ *```$", re.DOTALL | re.MULTILINE)
CODE = re.compile(r"`([^`]+)`")
COMMAND = re.compile(r"(?:\S*python -m )?(bench\.[a-z]\w*)\b(.*)", re.DOTALL)
OPTION = re.compile(r"--[a-z][a-z-]*")


def named() -> dict[str, set[str]]:
    """Options that are named of each module."""
    code = [one for path in DOCUMENTS for one in CODE.findall(BLOCK.sub("", path.read_text()))]
    code += [line.strip() for line in (ROOT / "Makefile").read_text().splitlines()]
    found: dict[str, set[str]] = {}
    for command in filter(None, map(COMMAND.fullmatch, code)):
        found.setdefault(command[1], set()).update(OPTION.findall(command[2]))
    return found


NAMED = named()


@pytest.mark.parametrize("module", sorted(NAMED))
def test_options_that_are_named_are_there(
    module: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.argv", [module, "--help"])
    with pytest.raises(SystemExit, match="0"):
        import_module(module).main()
    assert NAMED[module] - set(OPTION.findall(capsys.readouterr().out)) == set()
