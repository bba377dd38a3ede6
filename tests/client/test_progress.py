"""Progress in notebooks."""

import sys
from types import ModuleType
from typing import Any

import pytest
from isomatch import JobRecord
from isomatch._progress import ProgressBar

from service.http.openapi.examples import EXAMPLES

RECORD: dict[str, Any] = EXAMPLES["answers"]["get_job"]["200"]["example"]


def test_a_notebook_without_widgets_has_lines(monkeypatch: pytest.MonkeyPatch) -> None:
    shown: list[str] = []
    display = ModuleType("IPython.display")
    vars(display)["display"] = lambda output: shown.append(
        output._repr_mimebundle_([], [])["text/plain"]
    )
    monkeypatch.setitem(sys.modules, "IPython", ModuleType("IPython"))
    monkeypatch.setitem(sys.modules, "IPython.display", display)
    monkeypatch.setitem(sys.modules, "ipywidgets", None)
    monkeypatch.setattr("rich.console._is_jupyter", lambda: True)
    record = JobRecord.model_validate(RECORD)
    with ProgressBar() as bar:
        bar.update(record)
        bar.update(record)
    (line,) = shown
    assert line.rstrip().endswith(f"{record.kind} {record.id[:8]}: {record.stage}")
