"""A service of the documents' own: what they upload has the names that they give it."""

from collections.abc import Iterator

import pytest

from demo.stack import Stack, running_stack
from tests.stack import PATIENT


@pytest.fixture(scope="module")
def stack() -> Iterator[Stack]:
    with running_stack(PATIENT) as running:
        yield running
