"""Refusals on the page; names as plain text; the API key; use by keyboard."""

import re
from collections.abc import Callable

import httpx2
import numpy as np
from playwright.sync_api import Browser, BrowserContext, FilePayload, Locator, Page, expect

from broker.store import DEFAULT_KEYS
from service.http.security import read_keys
from service.standalone import EmbeddedServer
from tests.service.conftest import Api, Json, idle_api
from tests.service.page.conftest import accessible, job_of, opened
from tests.worker.figures import blob_file, two_blobs_file

NASTY = "<img src=x onerror=hit()><svg onload=hit()>&lt;b&gt;"
"""A name of a shape; what it says must be read, and not run."""


def file(name: str, data: bytes) -> FilePayload:
    return {"name": name, "mimeType": "application/octet-stream", "buffer": data}


def test_an_upload_that_is_refused(page: Page) -> None:
    page.goto("/")
    page.locator("#files").set_input_files([file("broken.off", b"OFF\n3 1 0\n0 0")])
    box = page.get_by_role("alert")
    expect(box).to_contain_text("OFF")
    assert len(box.inner_text()) > 20
    page.get_by_role("button", name="Dismiss").click()
    expect(box).to_have_count(0)
    expect(page.locator("#files")).to_be_focused()
    page.locator("#files").set_input_files([file("template.mrk.json", b'{"markups": []}')])
    expect(box).to_contain_text("This is a file of landmarks, no mesh")
    page.get_by_role("button", name="Dismiss").click()
    page.locator("#files").set_input_files([file("what.doc", b"no mesh")])
    expect(page.get_by_role("alert")).to_contain_text("ends in no supported format")
    with page.expect_file_chooser() as chosen:
        page.get_by_role("button", name="Choose another file").click()
    expect(page.get_by_role("alert")).to_have_count(0)
    usable = [file(f"{seed}.off", blob_file(2, seed=seed)) for seed in (81, 82)]
    chosen.value.set_files([*usable, file("one.doc", b""), file("two.doc", b"")])
    expect(page.locator(".chips li")).to_have_count(2)
    expect(page.get_by_text("2 of 4 files uploaded, 2 refused")).to_be_visible()


def test_nothing_is_lost_by_a_slip(page: Page) -> None:
    """Files dropped beside the area, two of them equal; half a landmark; a detour; a deletion."""
    page.goto("/#/nowhere")
    files = page.evaluate_handle(
        """(text) => {
          const dropped = new DataTransfer();
          for (const [name, said] of [['one.off', '1'], ['two.off', '2'], ['copy.off', '1']]) {
            dropped.items.add(new File([text.replace('OFF', `OFF # ${said}`)], name));
          }
          return dropped;
        }""",
        blob_file(2, seed=87).decode(),
    )
    page.dispatch_event("footer", "drop", {"dataTransfer": files})
    expect(page.locator(".chips li")).to_have_count(2)
    expect(page.locator(".chips li").first).to_contain_text("one.off")
    expect(page.locator(".uploads")).to_contain_text("copy.off has the same content as one.off")
    page.get_by_label("Points", exact=True).fill("13")
    page.get_by_label("Extend the match").check()
    page.get_by_text("Landmarks: points known").click()
    page.get_by_label("Vertex of the source").fill("5")
    page.get_by_role("button", name="Match", exact=True).click()
    expect(page.locator("#error-landmarks")).to_contain_text("Give a vertex of the target.")
    accessible(page)
    shape = page.locator(".chips a").first
    shape.click()
    page.get_by_role("button", name="Delete").click()
    dialog = page.get_by_role("dialog")
    # Equal files that are sent at the same time are one shape, which has the name of either.
    expect(dialog).to_contain_text(re.compile(r"Delete (one|copy)\.off\?"))
    expect(dialog.get_by_role("button", name="Keep")).to_be_focused()
    dialog.get_by_role("button", name="Keep").click()
    expect(page.get_by_role("button", name="Delete")).to_be_focused()
    page.go_back()
    expect(page.get_by_label("Points", exact=True)).to_have_value("13")
    expect(page.get_by_label("Extend the match")).to_be_checked()


def test_a_request_that_is_refused_names_the_field(page: Page, upload: Callable[..., Json]) -> None:
    shapes = [upload(blob_file(2, seed=seed))["id"] for seed in (81, 82)]
    page.goto(f"/#/with/{'/'.join(shapes)}")
    points = page.get_by_label("Points", exact=True)
    points.fill("2")
    page.get_by_role("button", name="Match", exact=True).click()
    expect(page.locator("#error-points")).to_contain_text("greater than or equal to 3")
    expect(points).to_have_attribute("aria-invalid", "true")
    expect(points).to_be_focused()
    expect(page.get_by_role("alert")).to_contain_text("points")
    expect(page.get_by_role("alert")).not_to_contain_text("`errors`")
    page.get_by_text("Landmarks: points known").click()
    # What is no number is not left out, which would ask for the default.
    for field, wrong, error in (
        (points, "1-6", page.locator("#error-points")),
        (page.get_by_label("Vertex of the source"), "e", page.locator("#error-landmarks")),
    ):
        field.fill("")
        field.press_sequentially(wrong)
        page.get_by_role("button", name="Match", exact=True).click()
        expect(error).to_contain_text("Give a")
        points.fill("13")


def test_rarer_parameters_are_folded(page: Page, upload: Callable[..., Json]) -> None:
    shapes = [upload(blob_file(2, seed=seed))["id"] for seed in (81, 82)]
    page.goto(f"/#/with/{'/'.join(shapes)}")
    rho = page.get_by_label("Rho", exact=True)
    expect(rho).not_to_be_visible()
    page.get_by_text("More parameters").click()
    rho.fill("1")
    expect(page.get_by_label("Normalise", exact=True).locator("option")).to_have_text(
        ["true", "false"]
    )
    page.get_by_role("button", name="Match", exact=True).click()
    expect(page.locator("#error-rho")).to_contain_text("greater than 1")


def test_shapes_that_cannot_be_matched_are_said_at_once(
    page: Page, upload: Callable[..., Json]
) -> None:
    shapes = [upload(two_blobs_file())["id"], upload(blob_file(2, seed=83))["id"]]
    page.goto(f"/#/with/{'/'.join(shapes)}")
    # Shapes are matched whole, unless somebody says otherwise.
    expect(page.get_by_label("largest component")).not_to_be_checked()
    page.get_by_text("More parameters").click()
    page.get_by_label("Points", exact=True).fill("200")
    page.get_by_label("Simplify", exact=True).fill("199")
    page.get_by_role("button", name="Match", exact=True).click()
    expect(page.locator("#error-simplify")).to_contain_text("199 vertices")


def test_a_job_that_fails_says_why(
    page: Page, http: httpx2.Client, upload: Callable[..., Json]
) -> None:
    # The last vertex of the file is in no face, so that it is no vertex of the surface.
    lines = blob_file(2, seed=83).decode().splitlines()
    vertices, faces, _ = map(int, lines[1].split())
    lines[1] = f"{vertices + 1} {faces} 0"
    lines.insert(2 + vertices, "0 0 0")
    shape = upload("\n".join(lines).encode())["id"]
    body = {"source": shape, "target": shape, "landmarks": [[0, vertices]], "eigenpairs": 20}
    job = http.post("/v1/matches", json=body).json()["id"]
    page.goto(f"/#/jobs/{job}")
    expect(page.locator("[data-state=failed]")).to_be_visible()
    expect(page.get_by_role("alert")).to_contain_text("landmarks")
    expect(page.get_by_text("Shapes: mesh.off")).to_be_visible()


def test_a_result_that_has_expired_is_requested_again(
    page: Page, api: Api, shapes: tuple[str, str]
) -> None:
    asked = {"source": shapes[0], "target": shapes[1], "points": 4, "eigenpairs": 20}
    job = httpx2.post(f"{api.url}/v1/matches", json=asked, timeout=60.0).json()["id"]
    page.goto(f"/#/jobs/{job}")
    page.locator("[data-drawn]").wait_for()
    api.store.client.delete(DEFAULT_KEYS.job_result(job))
    page.goto("/#/nowhere")
    page.goto(f"/#/jobs/{job}")
    expect(page.get_by_role("alert")).to_contain_text("no longer kept")
    page.get_by_role("link", name="Request it again").click()
    expect(page.locator(".chips li")).to_have_count(2)
    expect(page.get_by_label("Points", exact=True)).to_have_value("4")
    page.get_by_role("button", name="Match", exact=True).click()
    page.locator("[data-drawn]").wait_for()


def test_names_are_text(page: Page, http: httpx2.Client) -> None:
    ids = []
    # Words that all names begin with would be left out of the heat map.
    for seed, name in ((84, f"{NASTY} 84"), (85, f"{NASTY} 85"), (86, "plain")):
        form = {"name": name}
        answer = http.post("/v1/shapes", files={"file": ("a.off", blob_file(2, seed))}, data=form)
        ids.append(answer.json()["id"])
    page.goto("/")
    expect(page.get_by_role("link", name=f"{NASTY} 84", exact=True)).to_be_visible()
    page.goto(f"/#/shapes/{ids[0]}")
    expect(page.locator("h2")).to_have_text(f"{NASTY} 84")
    asked = {"source": ids[0], "target": ids[1], "points": 4, "eigenpairs": 20}
    job = http.post("/v1/matches", json=asked).json()["id"]
    page.goto(f"/#/jobs/{job}")
    page.locator("[data-drawn]").wait_for()
    assert f"{NASTY} 85" in page.locator("figcaption").nth(1).inner_text()
    compared = http.post("/v1/dissimilarities", json={"shapes": ids, "eigenpairs": 20}).json()["id"]
    page.goto(f"/#/jobs/{compared}")
    expect(page.locator(".heat .ytick text").first).to_contain_text("<img src=x onerro")
    assert page.locator("main img, main svg svg[onload], main b").count() == 0
    # A file's name is another way in.
    page.goto("/")
    name = "<img src=x onerror=hit()>.off"
    page.locator("#files").set_input_files([file(name, b"OFF")])
    expect(page.locator(".uploads .name")).to_have_text(name)
    expect(page.get_by_role("alert")).to_be_visible()


def test_a_key_is_asked_for_and_kept(browser: Browser, server: EmbeddedServer) -> None:
    with (
        idle_api(server, api_keys=read_keys("alice:wonderland")) as api,
        opened(browser, api.url) as page,
    ):
        page.goto("/")
        dialog = page.get_by_role("dialog")
        expect(dialog).to_contain_text("An API key is needed")
        field = page.get_by_label("Key", exact=True)
        for key in ("сказка", "looking-glass", "wonderland"):
            field.fill(key)
            # No browser can send the first.
            assert field.evaluate("field => field.validity.patternMismatch") is (key == "сказка")
            page.keyboard.press("Enter")
            if key == "looking-glass":
                expect(dialog).to_contain_text("API key is unknown")
        expect(page.get_by_text("No job yet.")).to_be_visible()
        page.reload()
        expect(page.get_by_text("No shape yet.")).to_be_visible()
        assert page.get_by_role("dialog").count() == 0
        assert page.evaluate("sessionStorage.getItem('isomatch-key')") == "wonderland"
        assert page.evaluate("localStorage.length") == 0


def test_addresses_of_nothing(page: Page) -> None:
    page.goto("/#/jobs/none")
    expect(page.get_by_role("alert")).to_contain_text("There is no job none.")
    expect(page).to_have_title("No such job – isomatch")
    expect(page.locator(".card, .awaited")).to_have_count(0)
    page.goto("/#/nowhere")
    expect(page.get_by_role("main")).to_contain_text("This address does not exist")


def chosen_cell(page: Page, heat: Locator, row: int, column: int) -> str:
    """Point at a cell of six rows, and click it; what was said of it."""
    heat.scroll_into_view_if_needed()
    box = heat.locator(".heatmaplayer").bounding_box()
    assert box is not None
    x, y = box["x"] + (column + 0.5) / 6 * box["width"], box["y"] + (row + 0.5) / 6 * box["height"]
    page.mouse.move(x - 2, y - 2)
    said = heat.locator(".hoverlayer .hovertext").text_content()
    page.mouse.click(x, y)
    return said or ""


def test_a_collection_is_compared_on_a_telephone(
    profile: BrowserContext, api: Api, http: httpx2.Client
) -> None:
    with opened(profile, api.url, viewport={"width": 390, "height": 800}) as page:
        page.goto("/")
        examples = page.get_by_role("button", name="Choose six generated shapes")
        examples.click()
        expect(page.locator(".chips li")).to_have_count(6)
        expect(examples).to_be_focused()
        expect(page.get_by_role("status").get_by_text("6 shapes are chosen.")).to_be_attached()
        page.get_by_role("button", name="Compare", exact=True).click()
        page.locator(".neighbours").first.wait_for()
        accessible(page)
        result = http.get(f"/v1/jobs/{job_of(page)}/result").json()
        csv = page.get_by_role("link", name="CSV", exact=True)
        expect(csv).to_have_attribute("href", f"/v1/jobs/{job_of(page)}/result.csv")
        heat = page.locator(".heat")
        # Light cells are drawn again, with numbers in black.
        expect(heat.locator(".heatmaplayer image")).to_have_count(2)
        rooted = [[max(0.0, value) ** 0.5 for value in row] for row in result["matrix"]]
        assert heat.evaluate("map => map.data[0].z") == rooted
        greatest = float(f"{max(map(max, result['matrix'])):.3g}")
        assert (
            float(heat.locator("[class*=cb][class$=tick] text").last.text_content() or "")
            == greatest
        )
        numbers = heat.locator(".heatmap-label").all_text_contents()
        written = [float(f"{value:.2g}") for row in result["matrix"] for value in row]
        np.testing.assert_allclose(sorted(map(float, numbers)), sorted(written))
        found = heat.locator(".heatmap-label text").evaluate_all(
            "texts => texts.map((text) => getComputedStyle(text).fill)"
        )
        assert set(found) == {"rgb(0, 0, 0)", "rgb(255, 255, 255)"}
        for name in heat.locator(".xtick text").all():
            box = name.bounding_box()
            assert box is not None
            assert box["x"] + box["width"] <= 390
        assert result["labels"] == ["human"] * 2 + ["cat"] * 2 + ["horse"] * 2
        text = chosen_cell(page, heat, 1, 3)
        assert text == f"human-walking.offcat-sitting.off{result['matrix'][1][3]:.4g}"
        detail = page.locator(".detail")
        expect(detail).to_contain_text("human-walking.off and cat-sitting.off")
        said = detail.locator("data").get_attribute("value")
        assert said is not None
        assert float(said) == result["matrix"][1][3]
        page.get_by_label("Dissimilarity of").select_option("horse-standing.off")
        page.get_by_label("and", exact=True).select_option("cat-standing.off")
        expect(detail).to_contain_text("horse-standing.off and cat-standing.off")
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
        page.locator(".neighbours button").last.press("Enter")
        expect(detail).to_be_focused()
        expect(detail).to_contain_text("horse-galloping.off")
        detail.get_by_role("link", name="Match these two").click()
        expect(page.locator(".chips li")).to_have_count(2)
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
