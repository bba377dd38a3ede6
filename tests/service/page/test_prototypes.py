"""A prototype on the page: learned from chosen shapes, looked at, and matched; and links."""

import io
from collections.abc import Callable

import httpx2
import numpy as np
from playwright.sync_api import Page, Route, expect
from scipy.spatial.distance import pdist

from tests.service.conftest import Api, Json
from tests.service.page.conftest import result_of, seen_by
from tests.worker.families import family, member
from tests.worker.figures import blob, off

PLACES = "s => s.data[1].x.map((x, i) => [x, s.data[1].y[i], s.data[1].z[i]])"
ADDRESS = "[aria-label='Address of this result']"


def examples(upload: Callable[..., Json], first: int) -> list[str]:
    """Ids of four shapes of one connectivity."""
    return [upload(data)["id"] for data in family(4, first=first)]


def test_a_late_answer_does_not_replace_what_was_filled_in(
    page: Page, upload: Callable[..., Json]
) -> None:
    shapes = examples(upload, 540)
    asked: list[Route] = []
    page.route("**/v1/structures", lambda route: asked.append(route))
    page.goto(f"/#/with/{'/'.join(shapes)}")
    page.get_by_label("Compare: dissimilarities of all pairs").focus()
    page.keyboard.press("ArrowDown")
    expect(page.get_by_role("button", name="Learn")).to_be_visible()
    asked[0].continue_()
    name = page.get_by_label("Name", exact=True)
    name.fill("mine")
    for late in asked[1:]:
        late.continue_()
    page.wait_for_load_state("networkidle")
    expect(name).to_have_value("mine")


def test_a_prototype_is_learned_and_matched(
    page: Page, api: Api, upload: Callable[..., Json]
) -> None:
    shapes = examples(upload, 500)
    page.goto(f"/#/with/{'/'.join(shapes)}")
    # By the keyboard: what is to be done, and in which way.
    page.get_by_label("Compare: dissimilarities of all pairs").focus()
    page.keyboard.press("ArrowDown")
    correspondence = page.get_by_label("Correspondence of the examples")
    # The counts of equal files may agree by chance, so that this is not chosen by itself.
    expect(correspondence).to_have_value("matches")
    correspondence.select_option("shared_connectivity")
    name = page.get_by_label("Name", exact=True)
    name.fill("<b>page")
    points = page.get_by_label("Points", exact=True)
    points.fill("2")
    page.get_by_role("button", name="Learn").click()
    expect(page.locator("#error-points")).to_contain_text("greater than or equal to 3")
    assert page.url.count("/with/") == 1
    points.fill("6")
    page.keyboard.press("Enter")
    page.wait_for_url("**/#/jobs/*")
    expect(page.locator("h2").last).to_have_text("<b>page, version 1")
    learned = result_of(page, api)
    assert learned["parameters"]["correspondence"] == "shared_connectivity"
    assert learned["prototype"]["points"] == 6
    rows = page.locator("tbody tr")
    expect(rows).to_have_count(4)
    expect(rows.first).to_contain_text("the points were chosen on it")
    expect(rows.nth(1)).to_contain_text("used")
    links = rows.locator("a").evaluate_all("links => links.map(a => a.getAttribute('href'))")
    assert links == [f"#/shapes/{shape}" for shape in shapes]

    page.get_by_role("link", name="Match it with a shape").click()
    expect(page.locator(".chips li")).to_have_count(1)
    page.locator(".chips a").click()
    expect(page).to_have_url(f"{api.url}/#/prototypes/{learned['prototype']['id']}")


def test_a_prototype_that_fails_names_the_shape(page: Page, upload: Callable[..., Json]) -> None:
    vertices, faces = blob(2, seed=97)
    first = upload(off(vertices, faces), "first.off")["id"]
    # As many vertices and triangles, but others.
    second = upload(off(vertices, faces[:, [1, 0, 2]][::-1]), "remeshed.off")["id"]
    page.goto(f"/#/task/learn/{first}/{second}")
    page.get_by_label("Points", exact=True).fill("6")
    page.get_by_label("Correspondence of the examples").select_option("shared_connectivity")
    page.get_by_role("button", name="Learn").click()
    page.wait_for_url("**/#/jobs/*")
    expect(page.locator("[data-state=failed]")).to_be_visible()
    expect(page.get_by_role("alert")).to_contain_text("shapes.1 (remeshed.off)")
    expect(page.get_by_role("alert")).to_contain_text("its triangles differ")
    page.get_by_role("link", name="Request it again").click()
    expect(page.get_by_role("button", name="Learn")).to_be_visible()


def test_a_prototype_is_looked_at(page: Page, api: Api, upload: Callable[..., Json]) -> None:
    shapes = examples(upload, 520)
    asked = {"shapes": shapes, "points": 6, "correspondence": "shared_connectivity"}
    job = httpx2.post(f"{api.url}/v1/prototypes", json=asked, timeout=60.0).json()["id"]
    page.goto(f"/#job={job}")
    made = page.get_by_role("link", name="Match it with a shape").get_attribute("href")
    assert made is not None
    made = made.rpartition("/")[2]
    page.goto(f"/#/prototypes/{made}")
    drawn = page.locator("[data-drawn='6'] .scene")
    expect(drawn).to_have_count(1)
    # Its points are where the archive has them, but for a turn, the scale, and a little height.
    record = httpx2.get(f"{api.url}/v1/prototypes/{made}", timeout=60.0).json()
    assert seen_by(drawn, record["view"], member(520)[0])
    archive = httpx2.get(f"{api.url}/v1/prototypes/{made}/archive", timeout=60.0).content
    with np.load(io.BytesIO(archive), allow_pickle=False) as arrays:
        given = pdist(arrays["positions"])
    seen = pdist(drawn.evaluate(PLACES))
    np.testing.assert_allclose(seen / seen.mean(), given / given.mean(), rtol=0.05)
    with page.expect_download() as saved:
        page.get_by_role("link", name="Archive (NPZ)").click()
    assert saved.value.suggested_filename == f"{made}.npz"
    page.goto(f"/#/with/{made}/{shapes[3]}")
    page.get_by_role("button", name="Match", exact=True).click()
    page.locator("[data-drawn]").wait_for()
    assert result_of(page, api)["source"] == made

    # With several shapes it is a batch.
    page.goto(f"/#/with/{made}/{shapes[2]}/{shapes[3]}")
    page.get_by_role("button", name="Match all").click()
    expect(page.get_by_role("table")).to_contain_text("2 of 2 matches")

    page.goto(f"/#/prototypes/{made}")
    expect(page.get_by_text("Jobs of this prototype")).to_be_visible()
    expect(page.locator(".list a").last).to_contain_text("Match: prototype, version")
    page.get_by_role("button", name="Delete").click()
    page.get_by_role("dialog").get_by_role("button", name="Delete").click()
    expect(page.get_by_text("Recent jobs")).to_be_visible()
    assert httpx2.get(f"{api.url}/v1/prototypes/{made}", timeout=60.0).status_code == 404
    page.goto(f"/#/prototypes/{made}")
    expect(page.get_by_role("alert")).to_contain_text("no prototype")


def test_a_prototype_of_an_earlier_version(
    page: Page, api: Api, upload: Callable[..., Json]
) -> None:
    """Results of learning have no view then."""

    def answer(route: Route) -> None:
        result = route.fetch().json()
        del result["prototype"]["view"]
        route.fulfill(json=result)

    asked = {"shapes": examples(upload, 560), "points": 6, "correspondence": "shared_connectivity"}
    job = httpx2.post(f"{api.url}/v1/prototypes", json=asked, timeout=60.0).json()["id"]
    page.route("**/result", answer)
    page.goto(f"/#job={job}")
    drawn = page.locator("[data-drawn='6'] .scene")
    drawn.wait_for()
    assert seen_by(drawn, np.eye(3), member(560)[0])


def test_a_prototype_whose_reference_is_gone(
    page: Page, api: Api, upload: Callable[..., Json]
) -> None:
    shapes = examples(upload, 540)
    asked = {"shapes": shapes, "points": 6, "correspondence": "shared_connectivity"}
    job = httpx2.post(f"{api.url}/v1/prototypes", json=asked, timeout=60.0).json()["id"]
    page.goto(f"/#job={job}")
    drawn = page.locator("[data-drawn='6'] .scene")
    drawn.wait_for()
    before = pdist(drawn.evaluate(PLACES))
    assert httpx2.delete(f"{api.url}/v1/shapes/{shapes[0]}", timeout=60.0).status_code == 204
    page.reload()
    drawn.wait_for()
    # The archive keeps the surface; here it has all vertices, for there are few.
    np.testing.assert_allclose(pdist(drawn.evaluate(PLACES)), before, rtol=1e-4)


def test_links_are_copied_and_opened(page: Page, api: Api, upload: Callable[..., Json]) -> None:
    shapes = examples(upload, 600)[:2]
    asked = {"source": shapes[0], "target": shapes[1], "points": 4, "eigenpairs": 20}
    job = httpx2.post(f"{api.url}/v1/matches", json=asked, timeout=60.0).json()["id"]
    # The clipboard of this page is a variable, and nobody may write to it in the end.
    page.add_init_script(
        "window.copied = null;"
        "if (navigator.clipboard) navigator.clipboard.writeText = async (text) => {"
        " if (window.denied) throw new Error('no'); window.copied = text; }"
    )
    page.goto(f"/#/jobs/{job}")
    copy = page.get_by_role("button", name="Copy link")
    copy.click()
    expect(page.get_by_text("Copied.")).to_be_visible()
    address = page.evaluate("window.copied")
    assert address == f"{api.url}/#job={job}"
    page.locator(".alternatives input").nth(1).check()
    copy.click()
    expect(page.get_by_text("Copied.")).to_be_visible()
    assert page.evaluate("window.copied") == f"{address}/1"
    page.locator(".alternatives input").nth(0).check()
    page.evaluate("window.denied = true")
    copy.click()
    expect(page.locator(ADDRESS)).to_have_value(address)

    page.goto("about:blank")
    page.goto(address)
    page.locator("[data-drawn]").wait_for()
    expect(page.locator("tr[data-pair]")).to_have_count(4)
