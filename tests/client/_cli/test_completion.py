"""Completion of commands and options by a shell."""

import pytest
from isomatch import cli
from typer.testing import CliRunner


@pytest.mark.parametrize(
    ("words", "completed"),
    [
        ("isomatch sha", "shapes"),
        ("isomatch shapes --url http://a.test de", "delete"),
        ("isomatch match --orient", "--orientation"),
    ],
)
def test_words_are_completed(words: str, completed: str) -> None:
    asked = {
        "_ISOMATCH_COMPLETE": "complete_bash",
        "COMP_WORDS": words,
        "COMP_CWORD": str(len(words.split()) - 1),
    }
    done = CliRunner().invoke(cli.app, [], prog_name="isomatch", env=asked)
    assert done.exit_code == 0, done.output
    assert completed in done.stdout.split()
