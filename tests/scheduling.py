"""Which tests run in one process: those of a file, and those that share a running service."""

from typing import Any

import pytest
from xdist.scheduler import LoadFileScheduling

SHARING = {
    "tests/service/": "API",
    "tests/client/": "stack",
    "tests/e2e/": "stack",
    "tests/worker/jobs/": "workers",
}
"""Folders whose tests share a service of their session, and its name. Each process that runs some
of them would start a service with workers of its own, which takes longer than most tests."""


def shared_by(test: str) -> str | None:
    """Name of the service that a test shares with others, by the test's id."""
    return next((name for folder, name in SHARING.items() if test.startswith(folder)), None)


class LoadServiceScheduling(LoadFileScheduling):  # type: ignore[misc]  # without types
    """Gives all tests that share a service to one process, and others file by file."""

    def _split_scope(self, nodeid: str) -> str:
        file: str = super()._split_scope(nodeid)
        return shared_by(nodeid) or file


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> LoadFileScheduling | None:
    """Take the place of ``--dist loadfile``."""
    return LoadServiceScheduling(config, log) if config.getoption("dist") == "loadfile" else None


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with those that share a service: they take longest, and must not come last."""
    names = [None, *reversed(dict.fromkeys(SHARING.values()))]
    items.sort(key=lambda item: names.index(shared_by(item.nodeid)), reverse=True)
