"""Shapes stand on the page as their records say."""

from collections.abc import Callable

import httpx2
import pytest
from playwright.sync_api import Page, Route, expect

from tests.service.conftest import Api, Json
from tests.service.page.conftest import eventually, seen_by
from tests.worker.figures import blob, off

VIEWS = [[0, 0, 1], [1, 0, 0], [0, 1, 0]], [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
"""Views that no rule would choose: x is up."""

SAID = "s => getComputedStyle(s, '::after').content"


@pytest.fixture
def shapes(page: Page, upload: Callable[..., Json]) -> list[str]:
    """Two shapes whose records have these views."""
    records = [upload(off(*blob(2, seed))) for seed in (760, 761)]
    views = {shape["id"]: view for shape, view in zip(records, VIEWS, strict=True)}

    def answer(route: Route) -> None:
        record = route.fetch().json()
        route.fulfill(json=record | {"view": views[record["id"]]})

    for shape in views:
        page.route(f"**/v1/shapes/{shape}", answer)
    return list(views)


def test_a_shape(page: Page, shapes: list[str]) -> None:
    page.goto(f"/#/shapes/{shapes[0]}")
    scene = page.get_by_label("in three dimensions")
    eventually(lambda: scene.evaluate("s => s.data !== undefined"))
    assert seen_by(scene, VIEWS[0], blob(2, 760)[0])


def test_what_is_awaited_is_said(page: Page, shapes: list[str]) -> None:
    """On a slow link, before modules, the record and plotly.js have arrived."""
    waiting: list[Route] = []

    def hold(route: Route) -> None:
        waiting.append(route)

    def held() -> Route:
        while not waiting:
            page.wait_for_timeout(20)  # routes are called meanwhile
        return waiting.pop()

    page.route(f"**/v1/shapes/{shapes[0]}", hold)
    page.route("**/plotly.min.js", hold)
    page.goto(f"/#/shapes/{shapes[0]}")
    expect(page.get_by_role("main")).to_have_text("Loading…")
    held().fallback()
    scene = page.get_by_label("in three dimensions")
    script = held()
    assert scene.evaluate(SAID) == '"Loading the drawing"'
    box = scene.bounding_box()
    script.continue_()
    eventually(lambda: scene.evaluate("s => s.data !== undefined"))
    assert scene.evaluate(SAID) == "none"
    assert scene.bounding_box() == box


def test_shapes_for_landmarks(page: Page, shapes: list[str]) -> None:
    page.goto(f"/#/with/{'/'.join(shapes)}")
    page.get_by_text("Landmarks: points known to correspond").click()
    page.locator("[data-ready]").wait_for()
    for end, seed, view in zip(("source", "target"), (760, 761), VIEWS, strict=True):
        assert seen_by(page.locator(f".scene[data-side={end}]"), view, blob(2, seed)[0])


def test_the_source_of_a_match(page: Page, api: Api, shapes: list[str]) -> None:
    asked = {"source": shapes[0], "target": shapes[1], "points": 6, "eigenpairs": 20}
    job = httpx2.post(f"{api.url}/v1/matches", json=asked, timeout=60.0).json()["id"]
    page.goto(f"/#/jobs/{job}")
    page.locator("[data-drawn]").wait_for()
    assert seen_by(page.locator(".scene[data-side=source]"), VIEWS[0], blob(2, 760)[0])
