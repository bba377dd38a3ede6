"""Options of every experiment, and its last line."""

import json
from pathlib import Path

import numpy as np
import pytest

from bench.command_line import command_line, parsed, print_json


def test_data_and_json(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.argv", ["bench", "--data", str(tmp_path), "--json"])
    parser = command_line("Measure: ``python -m bench.measure``.", data=True)
    assert parser.prog == "python -m bench.measure"
    arguments = parsed(parser)
    assert arguments.data == tmp_path
    print_json(arguments, {"pairs": 3})
    assert json.loads(capsys.readouterr().out) == {"pairs": 3}
    with pytest.raises(ValueError, match="not JSON compliant"):
        print_json(arguments, {"pairs": np.nan})


def test_data_that_is_no_folder_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.argv", ["bench", "--data", str(tmp_path / "absent")])
    with pytest.raises(SystemExit, match="2"):
        parsed(command_line("Measure: ``python -m bench.measure``.", data=True))
    assert "absent is not a folder" in capsys.readouterr().err


def test_the_folder_is_by_default_that_of_the_environment(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.argv", ["bench"])
    monkeypatch.delenv("ISOMATCH_DATA", raising=False)
    assert parsed(command_line("Measure: ``python -m bench.measure``.", data=True)).data is None
    monkeypatch.setenv("ISOMATCH_DATA", str(tmp_path))
    arguments = parsed(command_line("Measure: ``python -m bench.measure``.", data=True))
    assert arguments.data == tmp_path
    print_json(arguments, {"pairs": 3})
    assert not capsys.readouterr().out
