"""Landmarks carried along a dense match on the page: seen, dragged, moved by keys, downloaded."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import httpx2
import isomatch
import numpy as np
import pytest
from playwright.sync_api import Browser, BrowserContext, Locator, Page, expect

from solver.arrays import FloatArray, IntArray
from solver.mesh import surface_tree
from tests.service.conftest import Api, Json
from tests.service.page.conftest import (
    PATIENCE,
    POINTS,
    SMALL,
    SURFACE,
    camera,
    eventually,
    labelled,
    named,
    opened,
    place,
    turn,
)
from tests.worker.figures import blob, off

LABELS = ("tip, left", "<b>apex", "side", "lost")
AT = [0, 3, 42]
"""Vertices that the first three are at; the last is missing."""

PLACES = "s => s.data[1].x.map((x, i) => [x, s.data[1].y[i], s.data[1].z[i]])"


@dataclass(frozen=True)
class Carried:
    """A dense match of a shape with itself elsewhere, and landmarks of its source.

    Attributes
    ----------
    job
        Id of the match.
    surface
        Vertices and faces of the target.
    file
        The landmarks.
    """

    job: str
    surface: tuple[FloatArray, IntArray]
    file: Path


@pytest.fixture(scope="module")
def carried(
    api: Api, upload: Callable[..., Json], tmp_path_factory: pytest.TempPathFactory
) -> Carried:
    vertices, faces = blob(3)
    target = vertices + 7.0
    first = upload(off(vertices, faces) + b"# with landmarks\n", "template.off")["id"]
    second = upload(off(target, faces), "stored.off")["id"]
    asked = {"source": first, "target": second, "points": 8, "eigenpairs": 30, "dense": True}
    # It was uploaded again under another name.
    asked["target_name"] = "specimen.one.off"
    job = httpx2.post(f"{api.url}/v1/matches", json=asked, timeout=60.0).json()["id"]
    file = tmp_path_factory.mktemp("landmarks") / "template.mrk.json"
    rows = [(label, vertices[v]) for label, v in zip(LABELS, AT, strict=False)]
    isomatch.write_landmarks(file, [isomatch.LandmarkSet.of([*rows, (LABELS[-1], None)])])
    return Carried(job, (target, faces), file)


def shown(page: Page, carried: Carried, file: Path, end: str = "source") -> tuple[Locator, Locator]:
    """The view with the landmarks of a file, and both scenes."""
    page.goto(f"/#/landmarks/{carried.job}")
    page.locator("[data-ready]").wait_for()
    page.locator(f"#landmarks-{end}").set_input_files(str(file))
    page.locator("[data-drawn='4']").wait_for()
    return page.locator(".scene[data-side=source]"), page.locator(".scene[data-side=target]")


def saved(page: Page, ending: str, folder: Path) -> isomatch.LandmarkSet:
    """The landmarks as they are downloaded."""
    with page.expect_download() as download:
        page.get_by_role("button", name=ending.upper(), exact=True).click()
    assert download.value.suggested_filename == f"specimen.one.{ending}"
    path = folder / download.value.suggested_filename
    download.value.save_as(path)
    (found,) = isomatch.read_landmarks(path)
    return found


def row(page: Page, label: str) -> Locator:
    return page.locator("tr[data-landmark]").filter(has_text=label)


def distances(carried: Carried, positions: FloatArray) -> FloatArray:
    """How far positions are from the surface of the target."""
    return surface_tree(*carried.surface).distances(positions)


@pytest.fixture(scope="module")
def view(profile: BrowserContext, api: Api, carried: Carried) -> Iterator[Page]:
    with opened(profile, api.url, viewport=SMALL) as page:
        shown(page, carried, carried.file)
        yield page


def test_landmarks_are_carried_and_named(
    view: Page, carried: Carried, api: Api, tmp_path: Path
) -> None:
    source, target = (view.locator(f".scene[data-side={side}]") for side in ("source", "target"))
    for scene in (source, target):
        drawn = scene.evaluate("s => s.data[1].text")
        assert drawn == ["tip, left", "<b>apex", "side", "lost"]
    expect(view.get_by_role("heading").get_by_role("link").last).to_have_text("specimen.one.off")
    found = saved(view, "mrk.json", tmp_path)
    assert found.labels == LABELS
    assert found.present.tolist() == [True, True, True, False]
    # They are where the service carries these vertices, and as sure.
    with isomatch.Client(api.url) as client:
        there = client.transfer(carried.job, what="landmarks", points=AT).result().landmarks
    assert there is not None
    expected = [one.position for one in there]
    np.testing.assert_allclose(found.positions[:3], np.array(expected, float), atol=1e-5)
    said = [float(text.removeprefix("confidence ")) for text in found.descriptions[:3]]
    sure = np.array([one.confidence for one in there], dtype=np.float64)
    np.testing.assert_allclose(said, sure, atol=0.0051)
    assert found.descriptions[3] == ""
    shown_ = view.locator("tr[data-landmark] td:nth-child(2)")
    expect(shown_).to_have_text([*(f"{one:.2f}" for one in said), ""])
    for ending in ("fcsv", "csv"):
        again = saved(view, ending, tmp_path)
        assert again.labels == LABELS
        np.testing.assert_array_equal(again.positions, found.positions)


def test_shapes_are_drawn_whole_in_a_high_window(view: Page) -> None:
    view.set_viewport_size({"width": 720, "height": 900})
    for side in ("source", "target"):
        scene = view.locator(f".scene[data-side={side}]")
        scene.scroll_into_view_if_needed()
        eventually(partial(within, scene))
    view.set_viewport_size(SMALL)


def test_the_table_is_as_wide_as_its_column(view: Page) -> None:
    last = view.locator("tr[data-landmark] button").filter(has_text=LABELS[2])
    last.evaluate("button => button.append(' and a name of several long words')")
    for width in (1024, 1280):
        view.set_viewport_size({"width": width, "height": 560})
        wide = "s => [s.scrollWidth, s.clientWidth]"
        needed, there = view.locator(".corrected .scroll").evaluate(wide)
        assert needed <= there
    last.evaluate("button => button.lastChild.remove()")
    view.set_viewport_size(SMALL)


def within(scene: Locator) -> bool:
    """Whether the outermost vertices are drawn inside the box of the scene."""
    extreme = """s => ['x', 'y'].flatMap((name) => [1, -1].map((sign) =>
      s.data[0][name].reduce((b, v, i, all) => sign * v > sign * all[b] ? i : b, 0)))"""
    box = scene.bounding_box()
    assert box is not None
    places = [place(scene, SURFACE, vertex) for vertex in scene.evaluate(extreme)]
    return box["height"] <= box["width"] and all(
        box["x"] <= x <= box["x"] + box["width"] and box["y"] <= y <= box["y"] + box["height"]
        for x, y in places
    )


def test_shapes_are_turned_by_the_mouse(view: Page) -> None:
    source, target = (view.locator(f".scene[data-side={side}]") for side in ("source", "target"))
    first = camera(source)
    turn(view, source)
    eventually(lambda: camera(source) == camera(target) != first)
    eventually(lambda: labelled(source) and labelled(target))
    source.focus()
    view.keyboard.press("Home")
    eventually(lambda: camera(source) == camera(target) == first)


def test_a_landmark_is_dragged_on_the_surface(view: Page, carried: Carried, tmp_path: Path) -> None:
    target = view.locator(".scene[data-side=target]")
    before = saved(view, "csv", tmp_path).positions
    target.scroll_into_view_if_needed()
    # The one that is nearest to the viewer is not hidden.
    chosen = target.evaluate(
        "s => s.data[1].z.slice(0, 3).reduce((b, z, i, a) => z > a[b] ? i : b, 0)"
    )
    camera = "s => JSON.stringify(s._fullLayout.scene._scene.getCamera())"
    seen = target.evaluate(camera)
    here = np.array(place(target, POINTS, chosen))
    box = target.bounding_box()
    assert box is not None
    middle = np.array([box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"]])
    # Towards the middle, where there is surface.
    there = here + 18.0 * (middle - here) / np.linalg.norm(middle - here)
    view.mouse.move(*here)
    view.mouse.down()
    view.mouse.move(*there, steps=3)
    view.mouse.up()
    expect(row(view, LABELS[chosen])).to_contain_text("moved")
    # It is under the pointer but for the lift of what is drawn, and the shape was not turned.
    eventually(lambda: bool(np.linalg.norm(place(target, POINTS, chosen) - there) < 8))
    assert target.evaluate(camera) == seen
    after = saved(view, "csv", tmp_path).positions
    others = [i for i in range(3) if i != chosen]
    np.testing.assert_array_equal(after[others], before[others])
    assert np.linalg.norm(after[chosen] - before[chosen]) > 0.02
    assert distances(carried, after[:3]).max() < 1e-5
    remark = saved(view, "mrk.json", tmp_path).descriptions
    assert remark[chosen] == "corrected"
    assert all(remark[i].startswith("confidence ") for i in others)
    undo = view.get_by_role("button", name="Undo")
    undo.click()
    expect(undo).to_be_focused()
    np.testing.assert_array_equal(saved(view, "csv", tmp_path).positions, before)
    expect(undo).to_be_disabled()


def test_landmarks_are_moved_by_keys(view: Page, carried: Carried, tmp_path: Path) -> None:
    before = saved(view, "csv", tmp_path).positions
    apex = view.get_by_role("button", name="<b>apex", exact=True)
    apex.focus()
    expect(view.locator(".scene[data-side=target]")).to_have_attribute("data-pair", "1")
    for key in ("ArrowRight", "ArrowRight", "Shift+ArrowUp", "ArrowDown"):
        view.keyboard.press(key)
    moved = saved(view, "csv", tmp_path).positions
    step = 0.01 * 0.5 * np.ptp(carried.surface[0], axis=0).max()
    assert 0.5 * step < np.linalg.norm(moved[1] - before[1]) < 3.2 * step
    assert distances(carried, moved[:3]).max() < 1e-5
    side = view.get_by_role("button", name="side", exact=True)
    side.focus()
    view.keyboard.press("ArrowLeft")
    view.get_by_role("button", name="Reset <b>apex").click()
    expect(apex).to_be_focused()
    now = saved(view, "csv", tmp_path).positions
    np.testing.assert_array_equal(now[1], before[1])
    assert (now[2] != before[2]).any()
    view.get_by_role("button", name="Reset all").click()
    np.testing.assert_array_equal(saved(view, "csv", tmp_path).positions, before)
    # Undone is what was done last, resetting as well.
    view.get_by_role("button", name="Undo").click()
    np.testing.assert_array_equal(saved(view, "csv", tmp_path).positions, now)
    view.get_by_role("button", name="Reset all").click()
    expect(view.get_by_role("button", name="lost")).to_be_disabled()


def test_every_control_has_a_name(view: Page) -> None:
    named(view)


def test_landmarks_of_the_target_keep_their_confidence(
    browser: Browser, api: Api, carried: Carried, tmp_path: Path
) -> None:
    """On a telephone; also a file that cannot be read."""
    vertices, _ = carried.surface
    sure = isomatch.LandmarkSet(
        LABELS,
        np.vstack([vertices[AT], np.full(3, np.nan)]),
        "specimen",
        ("confidence 0.93", "confidence 0.41", "confidence 0.87", ""),
    )
    file = tmp_path / "specimen.fcsv"
    isomatch.write_landmarks(file, [sure])
    with opened(browser, api.url, viewport={"width": 390, "height": 800}, has_touch=True) as page:
        source, _ = shown(page, carried, file, "target")
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
        cells = page.locator("tr[data-landmark] td:nth-child(2)")
        expect(cells).to_have_text(["0.93", "in doubt, 0.41", "0.87", ""])
        # Both shapes have them.
        assert len(source.evaluate(PLACES)) == 4
        found = saved(page, "fcsv", tmp_path)
        assert found.descriptions == sure.descriptions
        np.testing.assert_allclose(found.positions[:3], vertices[AT], atol=1e-5)
        broken = tmp_path / "broken.fcsv"
        broken.write_text("# columns = id,x,y,z,label\n1,0,0,here,tip\n")
        page.locator("#landmarks-source").set_input_files(str(broken))
        box = page.get_by_role("alert")
        expect(box).to_contain_text('line 2: "here" is not a finite number')


@pytest.mark.parametrize("end", ["source", "target"])
def test_landmarks_far_from_the_surface_are_left_out(
    page: Page, carried: Carried, tmp_path: Path, end: str
) -> None:
    vertices = carried.surface[0] if end == "target" else carried.surface[0] - 7.0
    places = np.vstack([vertices[AT], vertices[0] + 50.0])
    file = tmp_path / "far.fcsv"
    certain = ("confidence 0.93",) * 4
    isomatch.write_landmarks(file, [isomatch.LandmarkSet(LABELS, places, "far", certain)])
    shown(page, carried, file, end)
    said = page.locator(".warnings")
    expect(said).to_contain_text("1 of 4 landmarks is far from the surface, 'lost' by ")
    expect(said).to_contain_text("it is left out")
    expect(row(page, "lost")).to_contain_text("left out")
    found = saved(page, "fcsv", tmp_path)
    assert found.present.tolist() == [True, True, True, False]
    # Another scale, and the other system of coordinates.
    isomatch.write_landmarks(file, [isomatch.LandmarkSet(LABELS, 100.0 * vertices[[0, 3, 42, 5]])])
    page.locator(f"#landmarks-{end}").set_input_files(str(file))
    expect(page.get_by_role("alert")).to_contain_text("4 of 4 landmarks are far from the surface")
    if end == "target":
        negated = vertices[[0, 3, 42, 5]] * [-1.0, -1.0, 1.0]
        isomatch.write_landmarks(file, [isomatch.LandmarkSet(LABELS, negated)])
        page.locator(f"#landmarks-{end}").set_input_files(str(file))
        expect(page.get_by_role("alert")).to_contain_text("but none with x and y negated")


def test_corrections_are_kept_in_the_tab(page: Page, carried: Carried, tmp_path: Path) -> None:
    shown(page, carried, carried.file)
    before = saved(page, "csv", tmp_path).positions
    page.get_by_role("button", name="side", exact=True).focus()
    page.keyboard.press("ArrowLeft")
    moved = saved(page, "csv", tmp_path).positions
    assert (moved[2] != before[2]).any()

    def kept() -> None:
        expect(row(page, "side")).to_contain_text("moved")
        np.testing.assert_array_equal(saved(page, "csv", tmp_path).positions, moved)

    page.get_by_role("link", name="Back to the match").click()
    page.get_by_role("link", name="Landmarks", exact=True).click()
    kept()
    page.go_back()
    expect(page.get_by_role("link", name="Landmarks", exact=True)).to_be_visible()
    page.go_forward()
    kept()
    page.reload()
    kept()
    expect(page.get_by_text("4 landmarks of template.mrk.json.")).to_be_visible()
    page.locator("[data-ready]").wait_for()
    # Others do not replace them without a question.
    page.locator("#landmarks-source").set_input_files(str(carried.file))
    page.get_by_role("dialog").get_by_role("button", name="Keep these").click()
    kept()
    page.get_by_role("button", name="Undo").click()
    np.testing.assert_array_equal(saved(page, "csv", tmp_path).positions, before)
    # What is undone does not come back.
    page.reload()
    expect(row(page, "lost")).to_contain_text("missing")
    np.testing.assert_array_equal(saved(page, "csv", tmp_path).positions, before)


def test_a_match_that_is_not_dense(page: Page, api: Api, shapes: tuple[str, str]) -> None:
    asked = {"source": shapes[0], "target": shapes[1], "points": 4, "eigenpairs": 20}
    job = httpx2.post(f"{api.url}/v1/matches", json=asked, timeout=60.0).json()["id"]
    page.goto(f"/#/landmarks/{job}")
    expect(page.get_by_role("alert")).to_contain_text("match again", timeout=PATIENCE)
    page.goto(f"/#/jobs/{job}")
    page.locator("[data-drawn]").wait_for()
    expect(page.get_by_role("link", name="Landmarks", exact=True)).to_have_count(0)
