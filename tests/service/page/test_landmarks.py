"""Landmarks: clicked on both shapes or typed, refused beside the field, and used by the match."""

import json
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import BrowserContext, Locator, Page, expect

from service.page import STATIC
from tests.service.conftest import Api, Json
from tests.service.page.conftest import SURFACE, eventually, opened, place, result_of

FIGURES = [STATIC / "shapes" / f"human-{pose}.off" for pose in ("standing", "walking")]
HIGHEST = "s => s.data[0].y.indexOf(Math.max(...s.data[0].y))"
VERTICES = "s => s.data[1].x.length"
POINTED_AT = "s => Boolean(s._fullLayout.scene._scene.oldEventData)"
"""Whether plotly.js has found out what the pointer is at, which takes it a frame."""


@pytest.fixture
def shapes(upload: Callable[..., Json]) -> list[str]:
    # Other bytes than those that other tests upload under names of their own.
    return [upload(path.read_bytes() + b"# with landmarks\n")["id"] for path in FIGURES]


def scene(page: Page, side: str) -> Locator:
    return page.locator(f".landmarks .scene[data-side={side}]")


def chosen(page: Page) -> Any:
    """The landmarks that would be asked for."""
    value = page.locator("#field-landmarks").input_value()
    return json.loads(value) if value else []


def press(page: Page, drawn: Locator, vertex: int, drag: int = 0) -> None:
    """Press the mouse on a vertex, and move it meanwhile."""
    drawn.scroll_into_view_if_needed()
    x, y = place(drawn, SURFACE, vertex)
    # The highest vertex is at the rim: the pointer is a little below it.
    page.mouse.move(x - 5, y + 5)
    page.mouse.move(x, y + 3, steps=3)
    page.wait_for_timeout(100)
    eventually(lambda: drawn.evaluate(POINTED_AT))
    page.mouse.down()
    if drag:
        page.mouse.move(x + drag, y + 3 + drag, steps=4)
    page.mouse.up()


def test_points_are_clicked_and_matched(page: Page, api: Api, shapes: list[str]) -> None:
    page.goto(f"/#/with/{'/'.join(shapes)}")
    page.get_by_text("Landmarks: points known").click()
    page.locator(".landmarks .pair[data-ready]").wait_for()
    source, target = scene(page, "source"), scene(page, "target")
    # Turning a shape chooses nothing.
    top = source.evaluate(HIGHEST)
    press(page, source, top, drag=40)
    page.wait_for_timeout(300)
    assert page.get_by_label("Vertex of the source").input_value() == ""
    other = target.evaluate(HIGHEST)
    press(page, target, other)
    expect(page.get_by_label("Vertex of the target")).not_to_have_value("")
    expect(page.locator(".landmarks")).to_contain_text("Now choose the corresponding point on")
    eventually(lambda: target.evaluate(VERTICES) == 1)
    assert chosen(page) == []
    press(page, source, top)
    expect(page.locator(".landmarks li")).to_have_count(1)
    ((first, second),) = chosen(page)
    # What was hit is at most a few edges from what was aimed at.
    for drawn, number, aimed in ((source, first, top), (target, second, other)):
        near = """(s, [a, b]) => Math.hypot(...['x', 'y', 'z'].map(
            (k) => s.data[0][k][a] - s.data[0][k][b]))"""
        assert drawn.evaluate(near, [number, aimed]) < 0.25
    eventually(lambda: source.evaluate(VERTICES) == 1)
    colors = [one.evaluate("s => s.data[1].marker.color[0]") for one in (source, target)]
    assert colors[0] == colors[1]

    page.get_by_label("Points", exact=True).fill("8")
    page.get_by_label("Extend the match to all vertices").uncheck()
    page.get_by_role("button", name="Match", exact=True).click()
    page.locator("[data-drawn]").wait_for()
    result = result_of(page, api)
    assert result["parameters"]["landmarks"] == [[first, second]]
    assert [first, second] in [[c["source"], c["target"]] for c in result["correspondences"]]


def test_vertices_are_typed(profile: BrowserContext, api: Api, shapes: list[str]) -> None:
    """By the keyboard, on a telephone."""
    with opened(profile, api.url, viewport={"width": 390, "height": 800}) as page:
        page.goto(f"/#/with/{'/'.join(shapes)}")
        page.locator(".landmarks summary").focus()
        page.keyboard.press("Enter")
        page.locator(".landmarks .pair[data-ready]").wait_for()
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
        refused = page.locator("#error-landmarks")
        page.get_by_label("Vertex of the source").focus()
        page.keyboard.type("17")
        page.keyboard.press("Enter")
        expect(refused).to_have_text("Give a vertex of the target.")
        page.keyboard.press("Tab")
        page.keyboard.type("1200")
        page.keyboard.press("Enter")
        expect(refused).to_contain_text("has no vertex 1200")
        page.keyboard.press("Backspace")
        expect(refused).to_be_hidden()
        page.keyboard.press("Enter")
        assert chosen(page) == [[17, 120]]
        page.keyboard.type("121")
        page.get_by_label("Vertex of the source").fill("17")
        page.get_by_role("button", name="Add this pair").click()
        expect(refused).to_contain_text("Vertex 17 of")
        expect(refused).to_contain_text("is a landmark already")
        # Nothing is asked for as long as it is there.
        page.get_by_role("button", name="Match", exact=True).click()
        expect(refused).to_contain_text("cannot be used yet")
        assert "#/with/" in page.url
        page.get_by_role("button", name="Remove landmark 1").click()
        assert chosen(page) == [[17, 121]]
        page.get_by_label("Vertex of the source").fill("")
        expect(page.locator(".landmarks li")).to_have_count(0)
        assert chosen(page) == []
