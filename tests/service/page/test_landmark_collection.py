"""Landmarks for several specimens on the page: carried, corrected, downloaded as one archive."""

import csv
import io
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path

import httpx2
import isomatch
import numpy as np
import pytest
from playwright.sync_api import BrowserContext, Page, Request, expect

from tests.service.conftest import Api, Json
from tests.service.page.conftest import PATIENCE, SMALL, accessible, opened
from tests.worker.figures import blob, off

LABELS = ("tip, left", "<b>apex", "lost")
SHIFTS = (7.0, -5.0)
"""Where the specimens are: each is the template elsewhere."""


def uploaded(upload: Callable[..., Json]) -> list[str]:
    """A template and two specimens, of one name."""
    vertices, faces = blob(3)
    names = ("template.off", "skull.off", "skull.ply.off")
    places = zip(names, (0.0, *SHIFTS), strict=True)
    return [upload(off(vertices + shift, faces) + b"# row\n", name)["id"] for name, shift in places]


def landmarks(folder: Path) -> Path:
    vertices, _ = blob(3)
    file = folder / "template.mrk.json"
    rows = [(LABELS[0], vertices[0]), (LABELS[1], vertices[42]), (LABELS[2], None)]
    isomatch.write_landmarks(file, [isomatch.LandmarkSet.of(rows)])
    return file


def archive(page: Page, ending: str, folder: Path) -> dict[str, bytes]:
    with page.expect_download() as download:
        page.get_by_role("button", name=f"ZIP of {ending.upper()}", exact=True).click()
    assert download.value.suggested_filename == "landmarks.zip"
    download.value.save_as(folder / "landmarks.zip")
    with zipfile.ZipFile(folder / "landmarks.zip") as opened_:
        assert opened_.testzip() is None
        return {name: opened_.read(name) for name in opened_.namelist()}


@pytest.fixture(scope="module")
def collection(
    profile: BrowserContext,
    api: Api,
    upload: Callable[..., Json],
    tmp_path_factory: pytest.TempPathFactory,
) -> Iterator[Page]:
    """A tab with the landmarks of two specimens, which is requested as users do."""
    folder = tmp_path_factory.mktemp("landmarks")
    with opened(profile, api.url, viewport=SMALL) as page:
        requested(page, uploaded(upload), folder)
        yield page


def requested(page: Page, ids: list[str], folder: Path) -> None:
    page.goto(f"/#/with/{'/'.join(ids)}")
    page.get_by_label("Landmarks: carry those of the first").check()
    page.get_by_role("button", name="Match for landmarks").click()
    page.wait_for_url("**/#/landmarks/*")
    rows = page.locator("tbody tr")
    expect(rows).to_have_count(2)
    # Landmarks are refused at once if there is a match to carry them along.
    expect(page.get_by_role("status").last).to_contain_text(
        "2 of 2 specimens matched", timeout=PATIENCE
    )
    broken = folder / "broken.csv"
    broken.write_text("label,x,y,z\na,0,0,here\n")
    page.locator("#landmarks-template").set_input_files(str(broken))
    expect(page.get_by_role("alert")).to_contain_text('line 2: "here" is not a finite number')
    isomatch.write_landmarks(broken, [isomatch.LandmarkSet.of([("far", [1e3, 1e3, 1e3])])])
    page.locator("#landmarks-template").set_input_files(str(broken))
    expect(page.get_by_role("alert")).to_contain_text("1 of 1 landmarks is far from the surface")
    sent: list[Request] = []
    page.on("request", lambda asked: sent.append(asked))
    page.locator("#landmarks-template").set_input_files(str(landmarks(folder)))
    expect(page.get_by_role("alert")).to_have_count(0)
    expect(page.get_by_role("status").last).to_have_text(
        "2 of 2 specimens matched, landmarks of template.mrk.json carried to 2."
    )
    assert len([asked for asked in sent if asked.method == "POST"]) == 2
    # Nothing is drawn: the service tells the positions.
    assert not any("/v1/shapes/" in asked.url for asked in sent)


def test_landmarks_of_a_template_are_carried_to_all(collection: Page, tmp_path: Path) -> None:
    page = collection
    for row in page.locator("tbody tr").all():
        expect(row).to_contain_text("2 of 3")
        expect(row).to_contain_text("carried")
    accessible(page)
    files = archive(page, "mrk.json", tmp_path)
    assert list(files) == ["skull.mrk.json", "skull.ply.mrk.json", "landmarks.csv"]
    vertices, _ = blob(3)
    for name, shift in zip(list(files)[:2], SHIFTS, strict=True):
        (tmp_path / name).write_bytes(files[name])
        (found,) = isomatch.read_landmarks(tmp_path / name)
        assert found.labels == LABELS
        assert found.present.tolist() == [True, True, False]
        # The specimen is the template elsewhere, and its map nearly the identity.
        apart = np.linalg.norm(found.positions[:2] - vertices[[0, 42]] - shift, axis=1)
        assert apart.max() < 0.2
        assert found.descriptions[0].startswith("confidence ")
    table = list(csv.DictReader(io.StringIO(files["landmarks.csv"].decode())))
    assert [one["specimen"] for one in table] == ["skull"] * 3 + ["skull.ply"] * 3
    assert [one["label"] for one in table[:3]] == [*LABELS]
    assert table[2]["x"] == table[2]["confidence"] == ""
    assert 0 < float(table[0]["confidence"]) <= 1


def test_what_is_corrected_is_in_the_archive(collection: Page, tmp_path: Path) -> None:
    page, rows = collection, collection.locator("tbody tr")
    files = archive(page, "mrk.json", tmp_path)
    table = list(csv.DictReader(io.StringIO(files["landmarks.csv"].decode())))
    page.get_by_role("link", name="skull.off", exact=True).click()
    page.locator("[data-drawn='3']").wait_for()
    page.get_by_role("button", name="<b>apex", exact=True).focus()
    page.keyboard.press("ArrowRight")
    expect(page.get_by_role("link", name="Previous: ")).to_have_count(0)
    page.get_by_role("link", name="Next: skull.ply.off").click()
    expect(page.get_by_role("heading").get_by_role("link").last).to_have_text("skull.ply.off")
    expect(page.get_by_role("link", name="Next: ")).to_have_count(0)
    page.get_by_role("link", name="All specimens").click()
    expect(rows.first).to_contain_text("1 moved")
    expect(rows.last).to_contain_text("carried")
    again = archive(page, "csv", tmp_path)
    assert list(again) == ["skull.csv", "skull.ply.csv", "landmarks.csv"]
    moved = list(csv.DictReader(io.StringIO(again["landmarks.csv"].decode())))
    assert [one["corrected"] for one in moved] == ["0", "1", "0", "0", "0", "0"]
    assert (moved[0], moved[3:]) == (table[0], table[3:])
    before, after = (np.array([float(one[1][axis]) for axis in "xyz"]) for one in (table, moved))
    assert 0 < np.linalg.norm(after - before) < 0.2
    with page.expect_download() as download:
        rows.first.get_by_role("button", name="CSV of skull.off", exact=True).click()
    assert Path(download.value.path()).read_bytes() == again["skull.csv"]

    # Others are not carried without a question, as the correction would be lost.
    page.locator("#landmarks-template").set_input_files(str(landmarks(tmp_path)))
    page.get_by_role("button", name="Keep these").click()
    expect(rows.first).to_contain_text("1 moved")
    page.locator("#landmarks-template").set_input_files(str(landmarks(tmp_path)))
    page.get_by_role("button", name="Carry them").click()
    expect(rows.first).to_contain_text("carried")
    expect(rows.last).to_contain_text("carried")
    assert archive(page, "mrk.json", tmp_path) == files
    page.get_by_role("link", name="Back to the matches").click()
    page.get_by_role("link", name="Landmarks", exact=True).click()
    expect(rows.first).to_contain_text("carried")


def test_landmarks_for_which_the_tab_has_no_room(collection: Page, tmp_path: Path) -> None:
    page = collection
    fill = """() => {
      for (let size = 2 ** 22; size >= 1; size /= 2) {
        try {
          for (;;) sessionStorage.setItem(`full-${sessionStorage.length}`, "x".repeat(size));
        } catch {}
      }
    }"""
    page.evaluate("sessionStorage.clear()")
    page.evaluate(fill)
    page.locator("#landmarks-template").set_input_files(str(landmarks(tmp_path)))
    expect(page.get_by_text("carried to 2. This tab has no room to keep them all")).to_be_visible()
    assert len(archive(page, "csv", tmp_path)) == 3
    page.evaluate("sessionStorage.clear()")


def test_landmarks_that_are_left_out_are_named(collection: Page, tmp_path: Path) -> None:
    """Also one whose name is longer than those that the service takes."""
    long, file = 300 * "a", landmarks(tmp_path)
    (given,) = isomatch.read_landmarks(file)
    rows = [*zip(given.labels[:2], given.positions[:2], strict=True), (long, [50.0, 0.0, 0.0])]
    isomatch.write_landmarks(file, [isomatch.LandmarkSet.of(rows)])
    collection.locator("#landmarks-template").set_input_files(str(file))
    said = f'Left out, far from the surface: "{long}".'
    expect(collection.get_by_text(said)).to_be_visible()
    for row in collection.locator("tbody tr").all():
        expect(row).to_contain_text("2 of 3")


def test_specimens_without_a_match_are_named(
    profile: BrowserContext,
    api: Api,
    http: httpx2.Client,
    upload: Callable[..., Json],
    tmp_path: Path,
) -> None:
    """On a telephone."""
    template, kept, _ = uploaded(upload)
    vertices, faces = blob(3, seed=9)
    gone = upload(off(vertices, faces) + b"# to be deleted\n", "gone.off")["id"]
    body = {"source": template, "targets": [kept, gone], "points": 8, "eigenpairs": 30}
    slow = {"source": template, "targets": [kept] * 4, "points": 256, "alternatives": 32}
    holding = http.post("/v1/batches", json={**slow, "coarse_points": 10}).json()
    job = http.post("/v1/batches", json={**body, "dense": True}).json()
    http.delete(f"/v1/shapes/{gone}").raise_for_status()
    http.delete(holding["links"]["self"]).raise_for_status()
    with opened(profile, api.url, viewport={"width": 390, "height": 800}) as page:
        page.goto(f"/#/landmarks/{job['id']}")
        page.locator("#landmarks-template").set_input_files(str(landmarks(tmp_path)))
        rows = page.locator("tbody tr")
        expect(rows.first).to_contain_text("carried", timeout=PATIENCE)
        expect(rows.last).to_contain_text("deleted")
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
        assert list(archive(page, "fcsv", tmp_path)) == ["skull.fcsv", "landmarks.csv"]


def test_a_batch_without_dense_maps(
    page: Page, http: httpx2.Client, upload: Callable[..., Json]
) -> None:
    template, kept, _ = uploaded(upload)
    body = {"source": template, "targets": [kept], "points": 8, "eigenpairs": 30}
    job = http.post("/v1/batches", json=body).json()
    page.goto(f"/#/landmarks/{job['id']}")
    expect(page.get_by_role("alert")).to_contain_text("match again", timeout=PATIENCE)
    page.goto(f"/#/jobs/{job['id']}")
    expect(page.get_by_role("table")).to_contain_text("1 of 1 matches")
    expect(page.get_by_role("link", name="Landmarks", exact=True)).to_have_count(0)
