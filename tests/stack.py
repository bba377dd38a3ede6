"""The whole stack as a user starts it: one for all tests of a session."""

from collections.abc import Iterator

import pytest

from demo.stack import Stack, running_stack

PATIENT = {"ISOMATCH_VALIDATION_WAIT": "240"}
"""Uploads are answered when they are read, however busy the machine."""


@pytest.fixture(scope="session")
def stack() -> Iterator[Stack]:
    """Run service, workers and store on a free port with a data directory of their own."""
    with running_stack(PATIENT) as running:
        yield running


@pytest.fixture
def url(stack: Stack, monkeypatch: pytest.MonkeyPatch) -> str:
    """Where the running service listens; the environment says so to clients too."""
    monkeypatch.setenv("ISOMATCH_URL", stack.url)
    return stack.url
