"""A registration on the page: asked for by the form, its mean moved, and its files."""

import io
from collections.abc import Callable, Iterator

import httpx2
import numpy as np
import pytest
import trimesh
from playwright.sync_api import BrowserContext, Locator, Page, Route, expect
from scipy.spatial.distance import pdist

from solver.arrays import FloatArray
from tests.service.conftest import Api, Json
from tests.service.page.conftest import (
    PATIENCE,
    SMALL,
    VERTICES,
    eventually,
    job_of,
    named,
    opened,
    result_of,
    seen_by,
)
from tests.worker.families import family, too_coarse

NAMES = [f"{'long name ' * 12}{k}.off" for k in range(4)]


@pytest.fixture(scope="module")
def registered(profile: BrowserContext, api: Api, upload: Callable[..., Json]) -> Iterator[Page]:
    """Two shapes were put in another order, and a template registered to them."""
    ids = [upload(data, name)["id"] for data, name in zip(family(4, first=700), NAMES, strict=True)]
    coarse = upload(too_coarse(), "coarse.off")["id"]
    with opened(profile, api.url, viewport=SMALL) as page:
        page.goto(f"/#/with/{'/'.join([ids[1], ids[0], coarse, *ids[2:]])}")
        page.get_by_label("Register the first").check()
        # The task stays chosen, and the keyboard where it was: at the chosen shapes.
        page.get_by_role("button", name=f"Put {NAMES[0]} first").press("Enter")
        expect(page.locator(".chips a").first).to_be_focused()
        expect(page.get_by_label("Register the first")).to_be_checked()
        expect(page.locator(".chips a").first).to_have_text(NAMES[0])
        page.get_by_label("Scale the specimens").check()
        page.get_by_role("button", name="Register").click()
        page.wait_for_url("**/#/jobs/*")
        page.locator("[data-drawn]").wait_for(timeout=PATIENCE)
        asked = result_of(page, api)
        assert asked["template"] == ids[0]
        assert [one["shape"] for one in asked["specimens"]] == [ids[1], coarse, *ids[2:]]
        assert asked["scale"]
        yield page


@pytest.fixture(scope="module")
def arrays(registered: Page, api: Api) -> dict[str, FloatArray]:
    answer = httpx2.get(f"{api.url}/v1/jobs/{job_of(registered)}/result.npz", timeout=60.0)
    with np.load(io.BytesIO(answer.content), allow_pickle=False) as found:
        return dict(found)


@pytest.fixture
def scene(registered: Page) -> Locator:
    return registered.locator(".scene")


def shown(scene: Locator, mean: FloatArray, shape: FloatArray) -> bool:
    """Whether a shape is drawn, turned, and as large as it is beside the mean."""
    drawn = np.array(scene.evaluate(VERTICES))
    return np.allclose(pdist(drawn) * np.abs(mean).max(), pdist(shape), rtol=1e-3, atol=1e-4)


def test_the_mean_is_moved_along_its_components(
    registered: Page, scene: Locator, arrays: dict[str, FloatArray]
) -> None:
    mean, steps = arrays["mean"], arrays["components"]
    deviations = np.sqrt(arrays["variances"])
    registered.get_by_role("button", name="Mean shape").click()
    eventually(lambda: shown(scene, mean, mean))
    sliders = registered.get_by_role("slider")
    # Of three registered specimens there are two components.
    expect(sliders).to_have_count(2)
    sliders.nth(1).press("End")
    expect(sliders.nth(1)).to_have_attribute("aria-valuetext", "+2.0 s.d.")
    eventually(lambda: shown(scene, mean, mean + 2 * deviations[1] * steps[1]))
    sliders.nth(0).press("Home")
    both = mean + 2 * (deviations[1] * steps[1] - deviations[0] * steps[0])
    eventually(lambda: shown(scene, mean, both))
    expect(registered.locator("output").first).to_have_text("−2.0 s.d.")
    assert not shown(scene, mean, mean)


def test_the_mean_stands_as_the_result_says(
    registered: Page, api: Api, scene: Locator, arrays: dict[str, FloatArray]
) -> None:
    registered.get_by_role("button", name="Mean shape").click()
    view = result_of(registered, api)["view"]
    eventually(lambda: seen_by(scene, view, arrays["mean"]))


@pytest.mark.parametrize("view", [[[0, 0, 1], [1, 0, 0], [0, 1, 0]], None])
def test_the_view_is_that_of_the_result(
    page: Page, registered: Page, arrays: dict[str, FloatArray], view: list[list[int]] | None
) -> None:
    """None: results of earlier versions have no view, and y is up."""

    def answer(route: Route) -> None:
        result = route.fetch().json()
        del result["view"]
        route.fulfill(json=result if view is None else result | {"view": view})

    page.route("**/result", answer)
    page.goto(f"/#/jobs/{job_of(registered)}")
    page.locator("[data-drawn]").wait_for()
    assert seen_by(page.locator(".scene"), np.eye(3) if view is None else view, arrays["mean"])


def test_specimens_are_shown_and_the_one_that_was_not_registered_is_named(
    registered: Page, scene: Locator, arrays: dict[str, FloatArray]
) -> None:
    rows = registered.locator("tbody tr")
    expect(rows).to_have_count(4)
    expect(rows.nth(1)).to_contain_text("not registered: the surfaces could not be registered")
    expect(rows.nth(1).get_by_role("button")).to_have_count(0)
    expect(rows.nth(2)).to_contain_text("confidence")
    registered.get_by_role("button", name=f"Show {NAMES[2]}").press("Enter")
    expect(registered.locator("figcaption")).to_contain_text(NAMES[2])
    # The third specimen is the second that was registered.
    specimen = arrays["mean"] + np.tensordot(arrays["scores"][1], arrays["components"], axes=1)
    eventually(lambda: shown(scene, arrays["mean"], specimen))


def test_registered_templates_are_downloaded(
    registered: Page, arrays: dict[str, FloatArray]
) -> None:
    for format_ in ("PLY", "OBJ", "GLB"):
        with registered.expect_download() as saved:
            registered.get_by_role("link", name=f"{format_} of {NAMES[3]}", exact=True).click()
        on = "-on-".join(f"{name[:35]}...{name[-39:-4]}" for name in (NAMES[0], NAMES[3]))
        assert saved.value.suggested_filename == f"{on}.{format_.lower()}"
        mesh = trimesh.load_mesh(saved.value.path(), file_type=format_.lower(), process=False)
        np.testing.assert_allclose(mesh.vertices, arrays["positions"][2], atol=1e-5)


def test_nothing_is_wider_than_a_phone(registered: Page) -> None:
    registered.set_viewport_size({"width": 390, "height": 700})
    wide = "document.documentElement.scrollWidth - innerWidth"
    eventually(lambda: registered.evaluate(wide) <= 0)
    # Nor are its tables, which a reader would have to scroll.
    tables = "[...document.querySelectorAll('.scroll')].map((e) => e.scrollWidth - e.clientWidth)"
    assert registered.evaluate(tables) == [0]
    named(registered)
    registered.set_viewport_size(SMALL)
