"""Options of every experiment, and its last line."""

import json
from pathlib import Path

import pytest

from bench.command_line import command_line, parsed, print_json


def test_data_and_json(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr("sys.argv", ["bench", "--data", "meshes", "--json"])
    arguments = parsed(command_line("Measure.", data=True))
    assert arguments.data == Path("meshes")
    print_json(arguments, {"pairs": 3})
    assert json.loads(capsys.readouterr().out) == {"pairs": 3}


def test_the_folder_is_by_default_that_of_the_environment(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.argv", ["bench"])
    monkeypatch.delenv("ISOMATCH_DATA", raising=False)
    assert parsed(command_line("Measure.", data=True)).data is None
    monkeypatch.setenv("ISOMATCH_DATA", "meshes")
    arguments = parsed(command_line("Measure.", data=True))
    assert arguments.data == Path("meshes")
    print_json(arguments, {"pairs": 3})
    assert not capsys.readouterr().out
