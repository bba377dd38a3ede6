"""``isomatch shapes``, without a service."""

import pytest

from tests.client.command_line import run

NOWHERE = "http://127.0.0.1:9"


@pytest.mark.parametrize(
    ("option", "advice"),
    [
        (["--url", NOWHERE], "give it after `delete`"),
        (["--json"], "leave it out of `delete`"),
        (["-q"], "leave it out of `delete`"),
    ],
)
def test_options_that_a_command_would_not_get_are_refused(option: list[str], advice: str) -> None:
    done = run("shapes", *option, "delete", 32 * "0", url=NOWHERE)
    assert (done.returncode, done.stdout) == (2, "")
    assert option[0] in done.stderr
    assert advice in done.stderr
