"""Tables of the command line: no id in them is shortened."""

import io
from typing import Any

import pytest
from isomatch._cli.registration_rendering import print_registration
from isomatch._cli.render import print_jobs
from isomatch._models import JobRecord
from rich.console import Console

from tests.client._http.test_connection import JOB
from tests.client._results.test_summary import IDS, registration, specimen


@pytest.fixture
def console() -> Console:
    return Console(file=io.StringIO(), width=200)


def printed(console: Console) -> str:
    assert isinstance(console.file, io.StringIO)
    return console.file.getvalue()


@pytest.mark.parametrize(
    ("of", "said"),
    [
        ({"source": IDS[1], "target": IDS[2]}, f"{IDS[1]} -> {IDS[2]}"),
        ({"shapes": IDS[1:3], "shape_count": 2}, f"{IDS[1]}, {IDS[2]}"),
        ({"prototype": f"p-{IDS[1]}"}, f"p-{IDS[1]}"),
    ],
)
def test_jobs_of_shapes_without_names(console: Console, of: dict[str, Any], said: str) -> None:
    print_jobs([JobRecord.model_validate(JOB | of)], console)
    assert said in printed(console)


def test_specimens(console: Console) -> None:
    print_registration(registration(specimen(1)), console)
    assert IDS[1] in printed(console).split()
