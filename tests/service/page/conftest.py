"""The page in a real browser: the system's Chromium, headless, drawing in software."""

import json
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from playwright.sync_api import (
    Browser,
    ConsoleMessage,
    Page,
    Playwright,
    ViewportSize,
    sync_playwright,
)

from tests.service.conftest import Api

CHROMIUM = ("chromium", "chromium-browser", "google-chrome")
PATIENCE = 30_000
"""Milliseconds: machines that run tests are busy, and draw without a graphics card."""

SMALL: ViewportSize = {"width": 720, "height": 560}
"""There is less to draw."""

OPTIONS = ("--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
"""Root has no sandbox; WebGL is drawn by the processor."""


def chromium() -> str:
    """The browser, or the test is skipped."""
    for name in CHROMIUM:
        found = shutil.which(name)
        if found is not None:
            return found
    pytest.skip(
        "no Chromium is installed, and `make browser` installs one only on Debian, for root:"
        " the page is not tested in a browser"
    )


@pytest.fixture(scope="package")
def playwright() -> Iterator[Playwright]:
    # It runs an event loop in this thread, which other tests must not find: not for the session.
    with sync_playwright() as running:
        yield running


@pytest.fixture(scope="package")
def browser(playwright: Playwright) -> Iterator[Browser]:
    launched = playwright.chromium.launch(executable_path=chromium(), args=list(OPTIONS))
    yield launched
    launched.close()


class Complaints(list[str]):
    """What the browser complains of: errors of scripts, of its console, of the page's policy."""

    def note(self, message: ConsoleMessage) -> None:
        # Browsers count what the service refuses among the errors of the page.
        if message.type == "error" and not message.text.startswith("Failed to load resource"):
            self.append(message.text)


Opened = Callable[..., Page]


@contextmanager
def opened(browser: Browser, url: str, **context: Any) -> Iterator[Page]:
    """Open a tab of its own, with which nothing may be wrong at the end."""
    complaints = Complaints()
    tab = browser.new_context(base_url=url, **context)
    page = tab.new_page()
    page.set_default_timeout(PATIENCE)
    page.on("console", complaints.note)
    page.on("pageerror", lambda error: complaints.append(error.stack or str(error)))
    # Whatever runs because markup was taken from a name says so here.
    page.add_init_script("window.hit = () => console.error('a name was run')")
    elsewhere: list[str] = []
    page.on("request", lambda asked: elsewhere.append(asked.url))
    yield page
    assert complaints == []
    assert [url_ for url_ in elsewhere if not url_.startswith((url, "blob:", "data:"))] == []
    tab.close()


@pytest.fixture
def page(browser: Browser, api: Api) -> Iterator[Page]:
    """A tab at the service that all tests share."""
    with opened(browser, api.url, viewport=SMALL) as tab:
        yield tab


def eventually(holds: Callable[[], bool]) -> None:
    """Wait until something holds, which drawing makes come true a little later."""
    deadline = time.monotonic() + PATIENCE / 1000
    while not holds():
        assert time.monotonic() < deadline
        time.sleep(0.05)


def job_of(page: Page) -> str:
    """Id of the job that the page shows."""
    return page.url.rpartition("#/jobs/")[2]


def result_of(page: Page, api: Api) -> dict[str, Any]:
    """The result of that job, as the API has it."""
    answer = page.request.get(f"{api.url}/v1/jobs/{job_of(page)}/result")
    result: dict[str, Any] = json.loads(answer.text())
    return result
