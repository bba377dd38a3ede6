"""``--help``: options under headings, and examples that are accepted."""

import re
import shlex
from pathlib import Path
from typing import Any

import pytest
from isomatch import cli
from isomatch._cli.options import FORMATS
from isomatch._models import structure_choice
from typer.main import get_command
from typer.testing import CliRunner

from broker.contracts import MatchParameters
from broker.contracts.shapes import MESH_FORMATS

PANELS = {
    "match": ["Options", "Shapes", "Structures", "Solver"],
    "compare": ["Options", "Shapes", "Structures", "Solver"],
    "landmarks": ["Options", "Shapes", "Structures", "Solver"],
    "prototype learn": ["Options", "Shapes", "Structures", "Mixtures"],
}
LAST = "Output and service"
longer = pytest.mark.parametrize("command", PANELS)


def asked(command: str) -> Any:
    """A command as it is known to what reads command lines."""
    found: Any = get_command(cli.app)
    for name in command.split():
        found = found.commands[name]
    return found


def epilog(command: str) -> list[str]:
    """The lines that its help ends with."""
    lines: list[str] = asked(command).epilog.splitlines()
    return lines


def test_all_formats_are_named() -> None:
    assert {name.lower() for name in re.findall("[A-Z]{3,}", FORMATS)} == set(MESH_FORMATS)


@longer
def test_options_are_under_headings(command: str) -> None:
    width = {"COLUMNS": "80", "NO_COLOR": "1"}
    asked_for = [*command.split(), "--help"]
    shown = CliRunner().invoke(cli.app, asked_for, env=width, catch_exceptions=False).stdout
    assert re.findall(r"╭─ (.*?) ─+╮", shown) == ["Arguments", *PANELS[command], LAST]
    first = shown.split("╭─ ")[2]
    assert "--points" in first
    assert "--url" in shown.split("╭─ ")[-1]
    # No line of an example is broken, and no default was taken for markup.
    lines = {line.strip() for line in shown.splitlines()}
    assert {re.sub(r"\[/?(dim|bold)\]", "", line).strip() for line in epilog(command)} <= lines
    assert not re.search(r"\s\.\s", shown)


@pytest.mark.parametrize("name", ["metric", "descriptor"])
def test_examples_of_structures_are_of_their_kind(name: str) -> None:
    (option,) = (one for one in asked("match").params if one.name == name)
    (example,) = re.findall(r"As in (\S+), may", option.help)
    MatchParameters.model_validate({name: structure_choice(example)})


def test_one_number_is_a_list_where_the_parameter_is_one() -> None:
    for text, given in (
        ("hks:times=0.1", {"name": "hks", "times": [0.1]}),
        ("hks:times=0.1,1", {"name": "hks", "times": [0.1, 1]}),
        ("wks:sigma=7", {"name": "wks", "sigma": 7}),
    ):
        assert structure_choice(text) == given
        MatchParameters.model_validate({"descriptor": given})


@pytest.mark.parametrize("command", [*PANELS, "transfer"])
def test_examples_are_accepted(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in (
        "a.off",
        "b.obj",
        "cat0.off",
        "human0.off",
        "scan0.ply",
        "stranger.off",
        "a.glb",
        "parts.seg",
    ):
        Path(name).touch()
    for name in ("template.ply", "template.mrk.json", "a.ply", "a.tps", "b.ply", "b.fcsv"):
        Path(name).touch()
    examples = [line.strip() for line in epilog(command) if line.startswith("  isomatch ")]
    assert len(examples) > 1
    for example in examples:
        words = [
            path
            for word in shlex.split(example.split(" | ")[0])[1:]
            for path in (sorted(map(str, Path().glob(word))) if "*" in word else [word])
        ]
        name = "prototype learn" if words[0] == "prototype" else words[0]
        with asked(name).make_context(name, words[len(name.split()) :]) as context:
            assert not context.args
