"""``isomatch shapes``, and limits of listings, without a service."""

import httpx2
import pytest
from isomatch._cli import exit_codes
from isomatch._clients import Client

from tests.client._http.test_connection import JOB, SHAPE
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


def listing(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> tuple[list[str], int]:
    """Ids that a command lists, of five in pages of two, and the number of pages it requests."""
    pages: list[int] = []

    def answer(request: httpx2.Request) -> httpx2.Response:
        start = int(request.url.params.get("cursor", "0"))
        pages.append(start)
        known = SHAPE if request.url.path == "/v1/shapes" else JOB
        items = [known | {"id": f"{place:032x}"} for place in range(5)]
        following = str(start + 2) if start + 2 < len(items) else None
        page = {"items": items[start : start + 2], "next_cursor": following}
        return httpx2.Response(200, json=page)

    service = httpx2.MockTransport(answer)
    monkeypatch.setattr(exit_codes, "Client", lambda url: Client(url, transport=service))
    done = run(*arguments, "-q", url=NOWHERE)
    assert done.returncode == 0, done.stderr
    return done.stdout.split(), len(pages)


@pytest.mark.parametrize("command", [["shapes"], ["shapes", "list"], ["jobs", "list"]])
def test_listings_have_a_limit(monkeypatch: pytest.MonkeyPatch, command: list[str]) -> None:
    every = [f"{place:032x}" for place in range(5)]
    assert listing(monkeypatch, *command) == (every, 3)
    assert listing(monkeypatch, *command, "--limit", "3") == (every[:3], 2)
    assert listing(monkeypatch, *command, "--limit", "2") == (every[:2], 1)
