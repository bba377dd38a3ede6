"""The page in a real browser: the system's Chromium, headless, drawing in software."""

import math
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import pairwise
from typing import Any

import httpx2
import numpy as np
import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import (
    Browser,
    BrowserContext,
    ConsoleMessage,
    Locator,
    Page,
    Playwright,
    ViewportSize,
    expect,
    sync_playwright,
)

from solver.arrays import FloatArray
from tests.service.conftest import Api, Json
from tests.waiting import until

CHROMIUM = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
"""The first draws no window, and opens a tab in a tenth of the time of the others."""
PATIENCE = 120_000
"""Milliseconds: machines that run tests are busy, and draw without a graphics card."""

SMALL: ViewportSize = {"width": 720, "height": 560}
"""There is less to draw."""

OPTIONS = (
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-gpu-compositing",
)
"""Root has no sandbox. WebGL is drawn by the processor, which composes pages faster without it."""


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


# Where a point of a drawn shape is on the screen, by the camera that plotly.js looks through.
PLACE = """(scene, [trace, number]) => {
  const drawing = scene._fullLayout.scene._scene;
  const { model, view, projection } = drawing.glplot.cameraParams;
  const moved = (m, v) => [0, 1, 2, 3].map(
    (r) => m[r] * v[0] + m[4 + r] * v[1] + m[8 + r] * v[2] + m[12 + r] * v[3]);
  const { x, y, z } = scene.data[trace];
  const point = [x, y, z].map((values, k) => values[number] * drawing.dataScale[k]);
  const [u, v, , w] = [model, view, projection].reduce((p, m) => moved(m, p), [...point, 1]);
  const box = scene.getBoundingClientRect();
  return [box.x + 0.5 * box.width * (1 + u / w), box.y + 0.5 * box.height * (1 - v / w)];
}"""

VERTICES = "s => s.data[0].x.map((x, v) => [x, s.data[0].y[v], s.data[0].z[v]])"

SURFACE, POINTS, RING, LABELS = 0, 1, 2, 3
"""What is drawn of a shape: its surface, points upon it, a ring round one of them, and names."""


@pytest.fixture(scope="package")
def playwright() -> Iterator[Playwright]:
    # It runs an event loop in this thread, which other tests must not find: not for the session.
    expect.set_options(timeout=PATIENCE)
    with sync_playwright() as running:
        yield running


@pytest.fixture(scope="package")
def profile(
    playwright: Playwright, api: Api, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[BrowserContext]:
    """A browser at the service that all tests share. Tabs have nothing in common but files.

    Its profile is on disk, where compiled scripts are kept: plotly.js takes most of the time in
    which a tab opens.
    """
    launched = playwright.chromium.launch_persistent_context(
        tmp_path_factory.mktemp("profile"),
        executable_path=chromium(),
        args=list(OPTIONS),
        timeout=PATIENCE,
        base_url=api.url,
    )
    yield launched
    launched.close()


@pytest.fixture(scope="package")
def browser(playwright: Playwright) -> Iterator[Browser]:
    """A browser for other services, and for screens of other kinds."""
    launched = playwright.chromium.launch(
        executable_path=chromium(), args=list(OPTIONS), timeout=PATIENCE
    )
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
def opened(
    browser: Browser | BrowserContext, url: str, viewport: ViewportSize = SMALL, **context: Any
) -> Iterator[Page]:
    """Open a tab of its own, with which nothing may be wrong at the end."""
    complaints = Complaints()
    if isinstance(browser, BrowserContext):
        page = browser.new_page()
        page.set_viewport_size(viewport)
    else:
        # The tab alone is in this context, and both are closed together.
        page = browser.new_page(base_url=url, viewport=viewport, **context)
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
    page.close()


@pytest.fixture
def page(profile: BrowserContext, api: Api) -> Iterator[Page]:
    """A tab at the service that all tests share."""
    with opened(profile, api.url) as tab:
        yield tab


NAMED = frozenset(
    [
        "button",
        "link",
        "textbox",
        "searchbox",
        "checkbox",
        "radio",
        "combobox",
        "listbox",
        "slider",
        "spinbutton",
        "progressbar",
        "image",
        "img",
        "Canvas",
        "SvgRoot",
        "application",
        "dialog",
        "region",
        "table",
        "DisclosureTriangle",
    ]
)
"""Roles of what has a name in Chromium's accessibility tree."""


def named(page: Page) -> None:
    """What screen readers are told of has names, and headings leave no level out."""
    session = page.context.new_cdp_session(page)
    nodes = session.send("Accessibility.getFullAXTree")["nodes"]
    session.detach()
    shown = [
        (node["role"]["value"], node.get("name", {}).get("value", "").strip(), node)
        for node in nodes
        if not node["ignored"]
    ]
    assert sum(role in NAMED for role, _, _ in shown) > 5
    assert [role for role, name, _ in shown if role in NAMED and not name] == []
    levels = [
        part["value"]["value"]
        for role, _, node in shown
        if role == "heading"
        for part in node["properties"]
        if part["name"] == "level"
    ]
    # The service's name, the page's title or those of its parts, and what is below them.
    assert levels[:2] == [1, 2]
    assert all(lower <= upper + 1 for upper, lower in pairwise(levels))


def accessible(page: Page) -> None:
    """What is shown meets the rules of axe-core: names, roles, focus, contrast."""
    named(page)
    broken = Axe().run(page).response["violations"]
    assert [(rule["id"], [node["html"] for node in rule["nodes"]]) for rule in broken] == []


def eventually(holds: Callable[[], bool]) -> None:
    """Wait until something holds, which drawing makes come true a little later."""
    until(holds, PATIENCE / 1000, pause=0.05)


def place(scene: Locator, trace: int, number: int) -> tuple[float, float]:
    """Where a vertex of the surface, or a point, of a shape that is drawn is on the screen."""
    x, y = scene.evaluate(PLACE, [trace, number])
    return x, y


def seen_by(scene: Locator, view: Any, vertices: FloatArray) -> bool:
    """Whether a shape is drawn in the coordinates of a view, but for scale and place."""
    drawn, seen = (
        one - one.mean(axis=0)
        for one in (np.array(scene.evaluate(VERTICES)), vertices @ np.transpose(view))
    )
    return np.allclose(drawn / drawn.std(), seen / seen.std(), atol=1e-3)


def camera(scene: Locator) -> Json:
    """Direction to the viewer and vertical of a drawing, and the size of the shape."""
    seen: Json = scene.evaluate(
        "s => ({ ...s._fullLayout.scene.camera, ...s._fullLayout.scene.aspectratio })"
    )
    return seen


def turn(page: Page, scene: Locator) -> None:
    """Turn a shape with the mouse."""
    scene.scroll_into_view_if_needed()
    box = scene.bounding_box()
    assert box is not None
    x, y = box["x"] + 0.1 * box["width"], box["y"] + 0.3 * box["height"]
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 0.2 * box["width"], y + 0.1 * box["height"], steps=5)
    page.mouse.up()


def labelled(scene: Locator) -> bool:
    """Whether the names that are seen are where their points are on the screen."""
    names, seen = scene.evaluate(f"s => [s.data[{POINTS}].text, s.data[{LABELS}].text]")
    apart = [
        math.dist(place(scene, LABELS, at), place(scene, POINTS, names.index(name)))
        for at, name in enumerate(seen)
    ]
    # What is missing has a name and no place.
    return len(seen) > 0 and max(filter(math.isfinite, apart)) < 0.5


def job_of(page: Page) -> str:
    """Id of the job that the page shows."""
    return page.url.rpartition("#/jobs/")[2]


def result_of(page: Page, api: Api) -> dict[str, Any]:
    """The result of that job, as the API has it."""
    result: dict[str, Any] = httpx2.get(
        f"{api.url}/v1/jobs/{job_of(page)}/result", timeout=60.0
    ).json()
    return result
