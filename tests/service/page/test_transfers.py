"""Transfers on the page: a file is carried along a dense match, and what is refused is said."""

import re
from collections.abc import Callable
from pathlib import Path

import isomatch
import numpy as np
import pytest
from playwright.sync_api import FilePayload, Page, Route, expect

from tests.service.conftest import Api, Json
from tests.service.page.conftest import SMALL, job_of, named
from tests.worker.figures import blob, off


@pytest.fixture(scope="module")
def match(api: Api, upload: Callable[..., Json]) -> tuple[str, int]:
    """Id of a dense match, and the number of vertices of both shapes."""
    vertices, faces = blob(2)
    first = upload(off(vertices, faces) + b"# to carry from\n", "parts.off")["id"]
    second = upload(off(vertices + 3.0, faces) + b"# to carry to\n", "<b>whole.off")["id"]
    with isomatch.Client(api.url) as client:
        job = client.match(first, second, points=6, eigenpairs=30, dense=True)
        job.result()
    return job.id, len(vertices)


def test_labels_are_carried(page: Page, api: Api, match: tuple[str, int], tmp_path: Path) -> None:
    job, count = match
    page.goto(f"/#/jobs/{job}")
    page.get_by_text("Transfer: carry values").click()
    file = tmp_path / "parts.csv"
    labels = np.arange(count) % 5
    page.get_by_label("Direction").select_option(label="from <b>whole.off to parts.off")
    # Fewer rows than vertices: refused beside the field.
    file.write_text("part\n" + "\n".join(map(str, labels[:10])))
    page.get_by_label("File of values").set_input_files(str(file))
    page.get_by_role("button", name="Transfer", exact=True).click()
    expect(page.locator("#error-attributes")).to_contain_text("10 rows")
    expect(page.get_by_role("alert")).to_contain_text("cannot be transferred")
    long = "p" * 100
    file.write_text(f"{long}\n" + "\n".join(map(str, labels)))
    page.get_by_label("File of values").set_input_files(str(file))
    page.get_by_role("button", name="Transfer", exact=True).click()
    page.wait_for_url(lambda url: "#/jobs/" in url and job not in url)
    expect(page).to_have_title(re.compile(r"^Transfer of labels: .* – isomatch$"))
    with page.expect_download() as saved:
        page.get_by_role("link", name="CSV").click()
    # The labels are drawn, and named beside the shape.
    page.locator(".carried[data-drawn]").wait_for()
    expect(page.locator(".legend li")).to_have_text(["0", "1", "2", "3", "4"])
    for side in ("source", "target"):
        scene = page.locator(f".scene[data-side={side}]")
        assert scene.evaluate("s => new Set(s.data[0].vertexcolor).size") > 5
    expect(page.get_by_text("look alike")).to_have_count(0)
    assert page.evaluate("document.documentElement.scrollWidth") <= SMALL["width"]
    named(page)
    expect(page.locator("[data-field=confidence] .badge")).to_contain_text("confidence")
    back = page.get_by_role("link", name="Back to the match")
    expect(back).to_have_attribute("href", f"#/jobs/{job}")
    rows = Path(saved.value.path()).read_text().splitlines()
    assert rows[0] == f"vertex,{long}"
    with isomatch.Client(api.url) as client:
        done = client.job(job).result()
    assert isinstance(done, isomatch.Match)
    expected = done.transfer(labels, "labels", direction="target_to_source")
    assert [int(row.split(",")[1]) for row in rows[1:]] == expected.tolist()
    assert job_of(page) != job


def test_labels_of_faces_are_carried_onto_faces_or_vertices(
    page: Page, api: Api, match: tuple[str, int], tmp_path: Path
) -> None:
    job, count = match
    faces = len(blob(2)[1])
    file = tmp_path / "parts.seg"
    file.write_text("\n".join(map(str, np.arange(faces) // 40)))
    for onto, number, rows in (
        ("what the values are of", "face", faces),
        ("vertices", "vertex", count),
    ):
        page.goto(f"/#/jobs/{job}")
        page.get_by_text("Transfer: carry values").click()
        page.get_by_label("File of values").set_input_files(str(file))
        page.get_by_label("Onto").select_option(label=onto)
        page.get_by_role("button", name="Transfer", exact=True).click()
        page.wait_for_url(lambda url: "#/jobs/" in url and job not in url)
        with page.expect_download() as saved:
            page.get_by_role("link", name="CSV").click()
        lines = Path(saved.value.path()).read_text().splitlines()
        assert lines[0] == f"{number},label"
        assert len(lines) == 1 + rows


def test_files_and_jobs_that_are_refused(page: Page, match: tuple[str, int]) -> None:
    page.goto(f"/#/jobs/{match[0]}")
    page.get_by_text("Transfer: carry values").click()
    broken: FilePayload = {
        "name": "parts.npz",
        "mimeType": "application/zip",
        "buffer": b"no archive",
    }
    page.get_by_label("File of values").set_input_files(broken)
    page.get_by_role("button", name="Transfer", exact=True).click()
    expect(page.get_by_role("alert")).to_contain_text("attribute")
    # The file of the shape has nothing: no job is requested.
    page.get_by_label("File of values").set_input_files([])
    for kind, do in (
        ("texture", "choose another kind"),
        ("labels", "choose a file of values"),
        ("colors", "choose a file of values"),
    ):
        page.get_by_label("Kind", exact=True).select_option(kind)
        page.get_by_role("button", name="Transfer", exact=True).click()
        said = f"parts.off has none in its own file; {do}."
        expect(page.locator("#error-attributes")).to_have_text(said)
    assert job_of(page) == match[0]
    # What is refused later leads back.
    with isomatch.Client(page.url.partition("#")[0].rstrip("/")) as client:
        failed = client.transfer(match[0], what="texture")
    page.goto(f"/#/jobs/{failed.id}")
    expect(page.locator("[data-state=failed]")).to_be_visible()
    expect(page.get_by_role("alert")).to_contain_text("Kind: ")
    expect(page.get_by_role("alert")).to_contain_text("no texture")
    page.get_by_role("link", name="Back to the match").click()
    page.wait_for_url(f"**/#/jobs/{match[0]}")


def test_colours_are_the_kind_of_a_coloured_shape_without_a_file(
    page: Page, match: tuple[str, int]
) -> None:
    def colored(route: Route) -> None:
        record = route.fetch().json()
        route.fulfill(json=record | {"has_colors": record["name"] == "parts.off"})

    page.route("**/v1/shapes/*", colored)
    page.goto(f"/#/jobs/{match[0]}")
    page.get_by_text("Transfer: carry values").click()
    kind = page.get_by_label("Kind", exact=True)
    expect(kind).to_have_value("colors")
    page.get_by_label("Direction").select_option("target_to_source")
    expect(kind).to_have_value("labels")
    page.get_by_label("Direction").select_option("source_to_target")
    expect(kind).to_have_value("colors")
    file: FilePayload = {"name": "parts.csv", "mimeType": "", "buffer": b"part"}
    page.get_by_label("File of values").set_input_files(file)
    expect(kind).to_have_value("labels")
    # What is chosen stays.
    kind.select_option("scalars")
    page.get_by_label("File of values").set_input_files([])
    expect(kind).to_have_value("scalars")


HUES = """(scene) => scene.data[0].vertexcolor.map((color) => {
  const [r, g, b] = color.match(/[0-9]+/g).map(Number);
  return [r, g, b].map((value) => value / Math.max(r, g, b));
})"""
"""Colours of the vertices without their brightness, which is that of the light."""


def test_values_are_drawn_on_both_shapes_by_one_scale(
    page: Page, api: Api, match: tuple[str, int]
) -> None:
    job, count = match
    height = blob(2)[0][:, 2]
    scenes = [page.locator(f".scene[data-side={side}]") for side in ("source", "target")]
    with isomatch.Client(api.url) as client:
        carried = client.transfer(job, {"height": height}, what="scalars")
        carried.wait()
        labelled = client.transfer(job, {"part": np.arange(count) % 20}, what="labels")
        labelled.wait()
        marked = client.transfer(job, what="landmarks", points=[3, 50])
        marked.wait()
    page.goto(f"/#/jobs/{carried.id}")
    page.locator(".carried[data-drawn]").wait_for()
    source, target = (np.array(scene.evaluate(HUES)) for scene in scenes)
    assert len(source) == count
    # The target is the same surface elsewhere: what is carried is nearly what was given.
    assert np.median(np.abs(source - target).max(axis=1)) < 0.1
    assert np.median(np.abs(source - target[::-1]).max(axis=1)) > 0.1
    expect(page.locator(".ends span")).to_have_count(2)
    page.goto(f"/#/jobs/{labelled.id}")
    expect(page.get_by_text("Of 20 labels some have colours that look alike")).to_be_visible()
    page.goto(f"/#/jobs/{marked.id}")
    page.locator(".carried[data-drawn='2']").wait_for()
    first, second = (scene.evaluate("s => s.data[1].marker.color") for scene in scenes)
    assert first == second
    assert len(first) == 2
    at = scenes[0].evaluate("s => s.data[1].x.map((x, i) => [x, s.data[1].y[i], s.data[1].z[i]])")
    assert np.isfinite(at).all()


def test_what_was_given_and_is_no_longer_kept_is_said(
    page: Page, api: Api, match: tuple[str, int]
) -> None:
    job, count = match
    with isomatch.Client(api.url) as client:
        file = client.upload_attributes({"gone": np.linspace(0.0, 1.0, count)})
        carried = client.transfer(job, file, what="scalars")
        carried.wait()
        client.delete_attributes(file)
    page.goto(f"/#/jobs/{carried.id}")
    page.locator(".carried[data-drawn]").wait_for()
    expect(page.locator(".scene")).to_have_count(1)
    said = "The source is not drawn: what was given is no longer kept."
    expect(page.get_by_text(said)).to_be_visible()
