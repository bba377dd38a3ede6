"""Consistent maps on the page: asked for by the form, their measures, and the map of a pair."""

import io
from collections.abc import Callable, Iterator
from functools import partial
from itertools import combinations

import httpx2
import numpy as np
import pytest
from playwright.sync_api import BrowserContext, Locator, Page, Position, expect
from scipy.spatial.distance import pdist

from solver.arrays import FloatArray
from tests.service.conftest import Api, Json
from tests.service.page.conftest import (
    PATIENCE,
    SMALL,
    eventually,
    job_of,
    named,
    opened,
    result_of,
)
from tests.worker.families import member, too_coarse
from tests.worker.figures import off

POINTS = "s => s.data[1].x.map((x, i) => [x, s.data[1].y[i], s.data[1].z[i]])"
MARKED = 32
NAMES = [f"{'long name ' * 12}{k}.off" for k in range(3)]


@pytest.fixture(scope="module")
def members() -> list[FloatArray]:
    """Vertices of three shapes of one class."""
    return [member(seed)[0] for seed in range(720, 723)]


@pytest.fixture(scope="module")
def mapped(
    profile: BrowserContext, api: Api, upload: Callable[..., Json], members: list[FloatArray]
) -> Iterator[Page]:
    """Three shapes, and one of too few vertices, were mapped to one another."""
    faces = member(720)[1]
    ids = [upload(off(one, faces), name)["id"] for one, name in zip(members, NAMES, strict=True)]
    ids.append(upload(too_coarse(), "<b>coarse.off")["id"])
    with opened(profile, api.url, viewport=SMALL) as page:
        page.goto(f"/#/with/{'/'.join(ids)}")
        page.get_by_label("Consistent maps between all").check()
        page.get_by_role("button", name="Map", exact=True).click()
        page.wait_for_url("**/#/jobs/*")
        page.locator(".heat .main-svg").first.wait_for(timeout=PATIENCE)
        assert [one["shape"] for one in result_of(page, api)["shapes"]] == ids
        yield page


@pytest.fixture(scope="module")
def arrays(mapped: Page, api: Api) -> dict[str, FloatArray]:
    answer = httpx2.get(f"{api.url}/v1/jobs/{job_of(mapped)}/result.npz", timeout=60.0)
    with np.load(io.BytesIO(answer.content), allow_pickle=False) as found:
        return dict(found)


def shown(page: Page, cells: list[list[float | None]]) -> bool:
    return bool(page.locator(".heat").evaluate("node => node.data[0].z") == cells)


def spread(vertices: FloatArray) -> list[int]:
    """Farthest point sampling of the positions that the page has."""
    middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    seen = ((vertices - middle) / (0.5 * np.ptp(vertices, axis=0).max())).astype(np.float32)
    points = seen.astype(np.float64)
    found = [int(np.linalg.norm(points, axis=1).argmax())]
    while len(found) < MARKED:
        apart = np.linalg.norm(points[:, None] - points[found], axis=2).min(axis=1)
        found.append(int(apart.argmax()))
    return found


def test_cells_are_the_measures_of_the_pairs(mapped: Page, api: Api) -> None:
    result = result_of(mapped, api)
    pairs = dict(zip(combinations(range(4), 2), result["pairs"], strict=True))
    for measure in ("cycle_error_before", "cycle_error", "confidence_before", "confidence"):
        mapped.get_by_label("Cells").select_option(measure)
        expected: list[list[float | None]] = [[None] * 4 for _ in range(4)]
        for (i, j), pair in pairs.items():
            value = pair[measure]
            if measure.startswith("confidence") and value is not None:
                value = value["probability"]
            expected[i][j] = expected[j][i] = value
        eventually(partial(shown, mapped, expected))


def test_what_does_not_fit_is_named_first(mapped: Page) -> None:
    shapes, pairs = mapped.get_by_role("table").all()
    expect(shapes.locator("tbody tr")).to_have_count(4)
    expect(shapes.locator("tbody tr").last).to_contain_text("<b>coarse.off")
    expect(shapes.locator("tbody tr").last).to_contain_text("none of its pairs could be matched")
    rows = pairs.locator("tbody tr")
    expect(rows).to_have_count(6)
    for place in range(3):
        expect(rows.nth(place)).to_contain_text("could not be registered")
    expect(rows.nth(3)).to_contain_text("confidence")
    expect(rows.nth(3)).to_contain_text("fits")
    rows.first.get_by_role("button").press("Enter")
    expect(mapped.locator(".detail")).to_contain_text(
        "No map: the surfaces could not be registered"
    )
    expect(mapped.locator(".detail")).to_be_focused()
    named(mapped)


def test_the_map_of_a_pair_is_drawn(
    mapped: Page, arrays: dict[str, FloatArray], members: list[FloatArray]
) -> None:
    # Both directions, by the table and by a cell of the heat map.
    mapped.get_by_role("table").last.get_by_role("button").nth(4).press("Enter")
    drawn(mapped, 0, 2, arrays, members)
    mapped.locator(".heat .nsewdrag").click(position=middle_of(mapped, 2, 0))
    drawn(mapped, 2, 0, arrays, members)


def test_results_stay_when_a_shape_is_deleted(
    mapped: Page, api: Api, members: list[FloatArray], arrays: dict[str, FloatArray]
) -> None:
    gone = result_of(mapped, api)["shapes"][2]["shape"]
    assert httpx2.delete(f"{api.url}/v1/shapes/{gone}", timeout=60.0).status_code == 204
    pairs = mapped.get_by_role("table").last.get_by_role("button")
    pairs.nth(5).press("Enter")
    expect(mapped.locator(".detail")).to_contain_text("A shape is no longer kept")
    pairs.nth(3).press("Enter")
    drawn(mapped, 0, 1, arrays, members)


def middle_of(page: Page, row: int, column: int) -> Position:
    box = page.locator(".heat .nsewdrag").bounding_box()
    assert box is not None
    return {"x": (column + 0.5) * box["width"] / 4, "y": (row + 0.5) * box["height"] / 4}


def drawn(
    page: Page, i: int, j: int, arrays: dict[str, FloatArray], members: list[FloatArray]
) -> None:
    """Points spread over the source are drawn with their images by the map."""
    title = page.locator(".detail h3")
    expect(title).to_have_text(f"{NAMES[i]} to {NAMES[j]}")
    page.locator(f".detail [data-drawn='{MARKED}']").wait_for()
    source = spread(members[i])
    images = arrays[f"map_{i}_{j}"][source]
    for side, vertices in (("source", members[i][source]), ("target", members[j][images])):
        points: Locator = page.locator(f".detail .scene[data-side={side}]")
        seen, given = pdist(points.evaluate(POINTS)), pdist(vertices)
        # Points are drawn a little above the surface.
        np.testing.assert_allclose(seen / seen.mean(), given / given.mean(), atol=0.05)
