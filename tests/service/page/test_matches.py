"""A match on the page, from two files to what is drawn, told and pointed at."""

import math
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import httpx2
import numpy as np
import pytest
from playwright.sync_api import (
    Browser,
    BrowserContext,
    FilePayload,
    Locator,
    Page,
    Route,
    ViewportSize,
    expect,
)

from service.page import STATIC
from tests.service.conftest import Api, Json
from tests.service.page.conftest import (
    LABELS,
    PATIENCE,
    POINTS,
    RING,
    accessible,
    camera,
    eventually,
    job_of,
    labelled,
    named,
    opened,
    place,
    result_of,
    turn,
)
from tests.worker.figures import blob_file

FIGURES = [STATIC / "shapes" / f"human-{pose}.off" for pose in ("standing", "walking")]


@pytest.fixture(scope="module")
def matched(profile: BrowserContext, api: Api) -> Iterator[Page]:
    """Two files were dropped, matched by the form, and the result is shown."""
    with opened(profile, api.url, viewport={"width": 900, "height": 700}) as page:
        page.goto("/")
        page.locator("#files").set_input_files([str(path) for path in FIGURES])
        expect(page.locator(".chips li")).to_have_count(2, timeout=PATIENCE)
        page.get_by_label("Points", exact=True).fill("12")
        # The form has the defaults of the parameters.
        expect(page.get_by_label("Tell left from right")).to_be_checked()
        expect(page.get_by_label("Find matched points between vertices")).not_to_be_checked()
        expect(page.get_by_label("Extend the match")).not_to_be_checked()
        page.get_by_label("Extend the match").check()
        page.get_by_role("button", name="Match", exact=True).click()
        page.wait_for_url("**/#/jobs/*")
        shown(page)
        yield page


def shown(page: Page) -> None:
    page.locator("[data-drawn]").wait_for()


def value(page: Page, field: str) -> float:
    text = page.locator(f"[data-field={field}] data").get_attribute("value")
    assert text is not None
    return float(text)


def scenes(page: Page) -> tuple[Locator, Locator]:
    return page.locator(".scene[data-side=source]"), page.locator(".scene[data-side=target]")


def rows(page: Page) -> list[tuple[int, int, float]]:
    script = "lines => lines.map(line => [...line.cells].slice(1).map(cell =>"
    script += " Number(cell.querySelector('data')?.value ?? cell.textContent)))"
    found: list[list[float]] = page.locator("tr[data-pair]").evaluate_all(script)
    return [(int(source), int(target), cost) for source, target, cost in found]


def pairs(answer: Json) -> list[tuple[int, int, float]]:
    return [(c["source"], c["target"], c["cost"]) for c in answer["correspondences"]]


def test_numbers_are_those_of_the_api(matched: Page, api: Api) -> None:
    accessible(matched)
    result = result_of(matched, api)
    assert rows(matched) == pairs(result)
    assert len(result["correspondences"]) == 12
    for field in ("energy", "lower_bound", "gap", "gromov_hausdorff"):
        assert value(matched, field) == pytest.approx(result[field], rel=1e-12)
    for field in ("second_order", "first_order", "linf"):
        assert value(matched, field) == result["distortion"][field]
    assert value(matched, "proof") == result["proof"]["energy"]
    expect(matched.locator("[data-field=proof]")).to_contain_text("proven")
    assert result["certified"]
    confidence, certificate = matched.locator("main .badge").all_inner_texts()
    assert confidence.startswith("confidence ")
    assert certificate == "certified"
    expect(matched.locator(".proof")).to_contain_text(
        "No better correspondence among this answer's candidates."
    )


def test_both_shapes_are_drawn_with_their_points(matched: Page, api: Api) -> None:
    result = result_of(matched, api)
    for side, scene, path in zip(("source", "target"), scenes(matched), FIGURES, strict=True):
        lines = path.read_text().splitlines()
        vertices, faces, _ = map(int, lines[1].split())
        counts = scene.evaluate("s => [s.data[0].x.length, s.data[0].i.length]")
        assert counts == [vertices, faces]
        # Distances between matched vertices are those of the file, up to scale and the lift.
        drawn = scene.evaluate("s => [s.data[1].x, s.data[1].y, s.data[1].z]")
        numbers = [pair[side] for pair in result["correspondences"]]
        given = [list(map(float, lines[2 + number].split())) for number in numbers]
        seen = [list(point) for point in zip(*drawn, strict=True)]
        ratios = [
            math.dist(seen[i], seen[j]) / math.dist(given[i], given[j])
            for i in range(12)
            for j in range(i)
            if math.dist(given[i], given[j]) > 0.5
        ]
        assert max(ratios) < 1.1 * min(ratios)
    # Partners have the same colour.
    colors = [scene.evaluate("s => s.data[1].marker.color") for scene in scenes(matched)]
    assert colors[0] == colors[1]
    assert len(set(colors[0])) == 12


def test_a_dense_map_transfers_colours(matched: Page, api: Api) -> None:
    result = result_of(matched, api)
    assert result["parameters"]["dense"]
    assert len(result["dense"]["source"]) == 1500
    transferring = matched.get_by_label("Colour the source by the dense map")
    expect(transferring).to_be_checked()
    colors = scenes(matched)[0].evaluate("s => new Set(s.data[0].vertexcolor).size")
    transferring.uncheck()
    source = scenes(matched)[0]
    eventually(lambda: source.evaluate("s => new Set(s.data[0].vertexcolor).size") < colors)
    transferring.check()


def test_the_partner_of_a_point_that_is_pointed_at(matched: Page) -> None:
    source, target = scenes(matched)
    source.scroll_into_view_if_needed()
    # The highest point is in front of nothing.
    pair = source.evaluate("s => s.data[1].y.indexOf(Math.max(...s.data[1].y))")
    x, y = place(source, POINTS, pair)
    matched.mouse.move(x - 4, y)
    matched.mouse.move(x, y, steps=3)
    expect(target).to_have_attribute("data-pair", str(pair))
    expect(source).to_have_attribute("data-pair", str(pair))
    # The ring is where the point is on the screen, also if the surface is in front of the point.
    assert place(target, RING, 0) == pytest.approx(place(target, POINTS, pair), abs=0.5)
    expect(matched.locator("tr.shown")).to_have_attribute("data-pair", str(pair))
    matched.mouse.move(2, 2)
    expect(target).to_have_attribute("data-pair", "")


def test_a_pair_is_chosen_by_the_keyboard(matched: Page) -> None:
    button = matched.locator("tr[data-pair='4'] button")
    button.focus()
    for scene in scenes(matched):
        expect(scene).to_have_attribute("data-pair", "4")
    matched.keyboard.press("Enter")
    expect(button).to_have_attribute("aria-pressed", "true")
    matched.keyboard.press("Tab")
    matched.keyboard.press("Shift+Tab")
    matched.keyboard.press("Enter")
    expect(button).to_have_attribute("aria-pressed", "false")
    button.blur()


def test_shapes_are_turned_by_keys_and_stay_linked(matched: Page) -> None:
    source, target = scenes(matched)
    first = camera(source)
    source.focus()
    for key in ("ArrowLeft", "ArrowUp", "+"):
        matched.keyboard.press(key)
    matched.locator(".alternatives input").nth(1).check()
    eventually(lambda: camera(source) == camera(target) != first)
    assert camera(source)["x"] > first["x"]
    seen = camera(source)
    # Turned by 15 degrees each, in which directions the rotation matrix says.
    towards = np.array([seen["eye"][axis] for axis in "xyz"]) / 2.0
    c, s = np.cos(np.pi / 12), np.sin(np.pi / 12)
    np.testing.assert_allclose(np.abs(towards), [s * c, s, c * c], atol=1e-6)
    matched.locator(".alternatives input").nth(0).check()
    target.focus()
    matched.keyboard.press("Home")
    eventually(lambda: camera(source) == camera(target) == first)


def test_shapes_are_turned_by_the_mouse_after_an_alternative(matched: Page) -> None:
    source, target = scenes(matched)
    first = camera(source)
    for which in (1, 0):
        matched.locator(".alternatives input").nth(which).check()
        expect(matched.locator("[data-field=confidence]")).to_have_count(1 - which)
    turn(matched, source)
    eventually(lambda: camera(source) == camera(target) != first)
    eventually(lambda: labelled(source) and labelled(target))
    source.focus()
    matched.keyboard.press("Home")
    eventually(lambda: camera(source) == camera(target) == first)


def test_numbers_are_in_front_of_the_surface(matched: Page) -> None:
    source, _ = scenes(matched)
    shown = f"s => s.data[{LABELS}].text"
    before = source.evaluate(shown)
    assert 0 < len(before) < 12
    # Each is where its point is on the screen.
    for at in (0, len(before) - 1):
        there = place(source, POINTS, int(before[at]) - 1)
        assert place(source, LABELS, at) == pytest.approx(there, abs=0.5)
    # From behind, the others are seen.
    source.focus()
    for _ in range(12):
        matched.keyboard.press("ArrowLeft")
    eventually(lambda: set(source.evaluate(shown)) | set(before) >= set(map(str, range(1, 13))))
    at = source.evaluate(shown)
    there = place(source, POINTS, int(at[0]) - 1)
    eventually(lambda: place(source, LABELS, 0) == pytest.approx(there, abs=0.5))
    matched.keyboard.press("Home")


def test_alternatives_can_be_looked_at(matched: Page, api: Api) -> None:
    result = result_of(matched, api)
    assert result["alternatives"]
    choices = matched.locator(".alternatives input")
    assert choices.count() == 1 + len(result["alternatives"])
    before = scenes(matched)[1].evaluate("s => s.data[1].x")
    choices.nth(1).check()
    alternative: dict[str, Any] = result["alternatives"][0]
    expect(matched.locator("[data-field=linf] data")).to_have_attribute(
        "value", str(alternative["distortion"]["linf"])
    )
    eventually(lambda: rows(matched) == pairs(alternative))
    # What is said is said of the alternative.
    said = alternative["relation"].replace("_", " ")
    expect(matched.locator(".alternatives label").nth(1)).to_contain_text(said)
    expect(matched.locator(".proof .badge")).to_have_text(f"alternative 1: {said}")
    expect(matched.locator("[data-field=confidence]")).to_have_count(0)
    assert scenes(matched)[1].evaluate("s => s.data[1].x") != before
    picture = matched.get_by_role("link", name="Picture (PNG)")
    expect(picture).to_have_attribute("href", re.compile(r"/result\.png\?alternative=1$"))
    expect(picture).to_have_text("Picture (PNG) of alternative 1")
    whose = matched.get_by_text("These files are of the answer, not of alternative 1")
    expect(whose).to_be_visible()
    # The address leads to the alternative.
    job = job_of(matched).removesuffix("/1")
    assert matched.url.endswith(f"/#/jobs/{job}/1")
    matched.reload()
    shown(matched)
    expect(choices.nth(1)).to_be_checked()
    expect(matched.locator(".proof .badge")).to_have_text(f"alternative 1: {said}")
    choices.nth(0).check()
    assert matched.url.endswith(f"/#/jobs/{job}")
    expect(matched.get_by_text("These files are of the answer")).to_be_hidden()
    expect(picture).to_have_attribute("href", re.compile(r"/result\.png$"))


def test_left_is_told_from_right_afterwards(page: Page, api: Api, matched: Page) -> None:
    # The shapes are those of the match before, which was told.
    expect(matched.get_by_role("button", name="Match with orientation")).to_have_count(0)
    told = result_of(matched, api)
    assert told["parameters"]["orientation"]
    asked = {"source": told["source"], "target": told["target"], "points": 10, "metric": "geodesic"}
    asked["orientation"] = False
    job = httpx2.post(f"{api.url}/v1/matches", json=asked, timeout=60.0).json()["id"]
    page.goto(f"/#/jobs/{job}")
    page.get_by_role("button", name="Match with orientation").click()
    page.wait_for_url(lambda url: "#/jobs/" in url and job not in url)
    shown(page)
    again = result_of(page, api)
    assert again["parameters"]["orientation"]
    for name in ("points", "metric", "coarse_points", "eigenpairs"):
        assert again["parameters"][name] == result_named(api, job)["parameters"][name]
    expect(page.get_by_role("button", name="Match with orientation")).to_have_count(0)


def test_an_unchecked_box_switches_orientation_off(page: Page, api: Api, matched: Page) -> None:
    told = result_of(matched, api)
    page.goto(f"/#/with/{told['source']}/{told['target']}")
    page.get_by_label("Points", exact=True).fill("8")
    page.get_by_label("Tell left from right").uncheck()
    page.get_by_role("button", name="Match", exact=True).click()
    page.wait_for_url("**/#/jobs/*")
    shown(page)
    result = result_of(page, api)
    assert not result["parameters"]["orientation"]
    assert not result["parameters"]["dense"]
    assert result["confidence"] is None
    expect(page.locator("[data-field=confidence]")).to_have_count(0)


def choose_again(page: Page, *names: str) -> None:
    """Upload the figures under other names."""
    page.goto("/")
    files: list[FilePayload] = [
        {"name": name, "mimeType": "", "buffer": path.read_bytes()}
        for name, path in zip(names, FIGURES, strict=True)
    ]
    page.locator("#files").set_input_files(files)
    expect(page.locator(".chips a")).to_have_text(names)


def test_a_comparison_has_the_names_of_the_uploads(page: Page, api: Api, matched: Page) -> None:
    choose_again(page, "b.off", "d4.off")
    page.get_by_label("Compare: dissimilarities of all pairs").check()
    page.get_by_role("button", name="Compare", exact=True).click()
    page.wait_for_url("**/#/jobs/*")
    heading = page.get_by_role("heading", name="Dissimilarities of 2 shapes")
    expect(heading).to_be_visible(timeout=60_000)
    result = result_of(page, api)
    assert result["names"] == ["b.off", "d4.off"]
    assert result["shapes"] == [result_of(matched, api)[side] for side in ("source", "target")]


def test_a_match_has_the_names_of_the_uploads(page: Page, api: Api, matched: Page) -> None:
    choose_again(page, "a.off", "c2.off")
    page.get_by_label("Points", exact=True).fill("8")
    page.get_by_label("Tell left from right").uncheck()
    page.get_by_role("button", name="Match", exact=True).click()
    page.wait_for_url("**/#/jobs/*")
    shown(page)
    assert page.locator("h2").last.inner_text() == "a.off and c2.off"
    result = result_of(page, api)
    assert (result["source_name"], result["target_name"]) == ("a.off", "c2.off")
    assert result["source"] == result_of(matched, api)["source"]
    # The list tells it from others of these shapes.
    job = job_of(page)
    page.goto("/#/")
    line = page.get_by_role("listitem").filter(has=page.locator(f"a[href='#/jobs/{job}']"))
    expect(line).to_contain_text("Match: a.off and c2.off points 8, no orientation done")


def answering(result: Json) -> Callable[[Route], None]:
    """A result in place of the service's."""

    def answer(route: Route) -> None:
        route.fulfill(json=result)

    return answer


def test_confidence_is_shown_with_the_reasons(page: Page, api: Api, matched: Page) -> None:
    result, job = result_of(matched, api), job_of(matched)
    sure: Json = {"probability": 0.97, "reasons": []}
    doubt: Json = {"probability": 0.31, "reasons": ["the <b>mirror</b> image fits", "few points"]}
    for confidence, badge, said in (
        (sure, "confidence 97 %", "The answer is almost certainly right."),
        (doubt, "in doubt, confidence 31 %", "The answer may be wrong."),
    ):
        page.route(f"**/v1/jobs/{job}/result", answering(result | {"confidence": confidence}))
        page.goto("/#/")
        page.goto(f"/#/jobs/{job}")
        note = page.locator("[data-field=confidence]")
        expect(note.locator(".badge")).to_have_text(badge)
        expect(note).to_contain_text(said)
        expect(note.get_by_role("listitem")).to_have_text(confidence["reasons"])
        certificate = page.locator(".proof .badge")
        expect(certificate).to_have_text("certified")
        expect(certificate).to_have_class("badge" if confidence is doubt else "badge good")


def test_what_a_part_lacks_is_grey(page: Page, api: Api, matched: Page) -> None:
    result, job = result_of(matched, api), job_of(matched)
    inverse = result["dense"]["inverse"]
    half = {name: values[: len(values) // 2] for name, values in inverse.items()}
    changed = result | {
        "dense": result["dense"] | {"inverse": half},
        "overlap": {"part": "source", "source": 1.0, "target": 0.5},
        "distortion": result["distortion"] | {"first_order": None},
    }
    page.route(f"**/v1/jobs/{job}/result", answering(changed))
    page.goto(f"/#/jobs/{job}")
    shown(page)
    grey = r"s => s.data[0].vertexcolor.filter((c) => /rgb\((\d+),\1,\1\)/.test(c)).length"
    lacking = len(inverse["target"]) - len(half["target"])
    assert scenes(page)[1].evaluate(grey) == lacking
    assert scenes(page)[0].evaluate(grey) == 0
    expect(page.get_by_text("Grey: not on the other shape.")).to_be_visible()
    # Parts are matched without descriptors.
    expect(page.locator("[data-field=second_order]")).to_be_visible()
    expect(page.locator("[data-field=first_order]")).to_have_count(0)


def test_less_energy_of_another_correspondence_is_explained(
    page: Page, api: Api, matched: Page
) -> None:
    result, job = result_of(matched, api), job_of(matched)
    energy = result["energy"]
    less = [other | {"energy": 0.5 * energy} for other in result["alternatives"]]
    more = [other | {"energy": 2.0 * energy} for other in result["alternatives"]]
    proof = result["proof"]
    sure, doubt = ({"probability": p, "reasons": []} for p in (0.97, 0.07))
    for others, proven, subject, confidence in (
        (less, energy, "An alternative has", sure),
        (more, 0.9 * energy, "A correspondence of all samples has", sure),
        (less, 0.9 * energy, "An alternative and a correspondence of all samples have", doubt),
        (more, energy, None, sure),
    ):
        changed = result | {"alternatives": others, "proof": proof | {"energy": proven}}
        changed |= {"confidence": confidence}
        page.route(f"**/v1/jobs/{job}/result", answering(changed))
        page.goto("/#/")
        page.goto(f"/#/jobs/{job}")
        said = page.locator("p.proof")
        expect(said).to_contain_text("No better correspondence among this answer's candidates.")
        if subject is None:
            expect(said).not_to_contain_text("less energy")
        else:
            expect(said).to_contain_text(f"{subject} less energy, but the answer was chosen by")
            reason = "is in doubt here." if confidence is doubt else "tells it from others, such as"
            expect(said).to_contain_text(f"registration in space, which {reason}")


def result_named(api: Api, job: str) -> Json:
    result: Json = httpx2.get(f"{api.url}/v1/jobs/{job}/result", timeout=60.0).json()
    return result


def test_a_match_is_repeated_with_its_parameters(page: Page, api: Api, matched: Page) -> None:
    told = result_of(matched, api)
    first, second = told["correspondences"][:2]
    asked: Json = {
        "source": told["source"],
        "target": told["target"],
        "points": 9,
        "metric": "geodesic",
        "descriptor": [{"name": "geodesic_histogram", "bins": 12}],
        "orientation": False,
        "normalise": False,
        "rho": 2.0,
        "landmarks": [[first["source"], first["target"]], [second["source"], second["target"]]],
    }
    job = httpx2.post(f"{api.url}/v1/matches", json=asked, timeout=60.0).json()["id"]
    page.goto(f"/#/with/{told['source']}/{told['target']}")
    # What was entered for another match is not mixed with it.
    page.get_by_label("Extend the match").check()
    page.goto(f"/#/jobs/{job}")
    shown(page)
    expect(page.get_by_text("(choose descriptor again)")).to_be_visible()
    page.get_by_role("link", name="Match again with other parameters").click()
    points = page.get_by_label("Points", exact=True)
    expect(points).to_have_value("9")
    expect(page.get_by_label("Metric", exact=True)).to_have_value("geodesic")
    expect(page.get_by_label("Tell left from right")).not_to_be_checked()
    expect(page.get_by_label("Extend the match")).not_to_be_checked()
    expect(page.get_by_label("Rho", exact=True)).to_have_value("2")
    expect(page.get_by_label("Normalise", exact=True)).to_have_value("false")
    expect(page.locator(".landmarks li")).to_have_count(2)
    page.get_by_role("button", name="Match", exact=True).click()
    page.wait_for_url(lambda url: "#/jobs/" in url and job not in url)
    shown(page)
    again = result_of(page, api)["parameters"]
    before = result_named(api, job)["parameters"]
    assert again == before | {"descriptor": told["parameters"]["descriptor"]}
    page.go_back()
    page.get_by_role("button", name="Defaults").click()
    expect(points).to_have_value("32")
    expect(page.get_by_label("Metric", exact=True)).to_have_value("")
    expect(page.get_by_label("Tell left from right")).to_be_checked()
    expect(page.get_by_label("Normalise", exact=True)).to_have_value("")
    page.reload()
    expect(points).to_have_value("32")


# Contrast of the names of points to the background, by WCAG.
CONTRAST = f"""scene => {{
  const light = (color) => {{
    const context = new OffscreenCanvas(1, 1).getContext("2d");
    context.fillStyle = color;
    context.fillRect(0, 0, 1, 1);
    const linear = [...context.getImageData(0, 0, 1, 1).data].map((value) =>
      (value / 255 <= 0.04045 ? value / 255 / 12.92 : ((value / 255 + 0.055) / 1.055) ** 2.4));
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
  }};
  const background = [scene, document.body].map((node) => getComputedStyle(node).backgroundColor)
    .find((color) => color !== "rgba(0, 0, 0, 0)");
  const [a, b] = [scene.data[{LABELS}].textfont.color, background].map(light).sort((x, y) => y - x);
  return (a + 0.05) / (b + 0.05);
}}"""


def test_shapes_are_below_one_another_on_a_telephone(
    browser: Browser, api: Api, matched: Page
) -> None:
    size: ViewportSize = {"width": 400, "height": 800}
    with opened(browser, api.url, viewport=size, color_scheme="dark") as page:
        page.goto(f"/#/jobs/{job_of(matched)}")
        shown(page)
        source, target = (scene.bounding_box() for scene in scenes(page))
        assert source is not None
        assert target is not None
        assert source["y"] + source["height"] <= target["y"]
        assert scenes(page)[0].evaluate(f"s => s.data[{LABELS}].text.length > 0")
        assert scenes(page)[0].evaluate(CONTRAST) >= 4.5
        assert page.evaluate("document.documentElement.scrollWidth") <= 400
        accessible(page)


def test_an_address_survives_a_reload(matched: Page, api: Api) -> None:
    before, job = rows(matched), job_of(matched)
    matched.reload()
    shown(matched)
    assert rows(matched) == before
    assert job_of(matched) == job
    with matched.expect_download() as saved:
        matched.get_by_role("link", name="JSON").click()
    assert Path(saved.value.path()).stat().st_size > 1000
    # The files say what is in them, those of the registered source, too.
    files = matched.get_by_role("paragraph").filter(has_text="Everything: JSON")
    for text, links in (
        ("Pairs: CSV", ["result.csv"]),
        ("Target in the source's colours: PLY OBJ", ["result.ply", "result.obj"]),
        ("Both in corresponding colours: GLB", ["result.glb"]),
        ("Source registered", ["registered.ply", "registered.obj", "registered.glb"]),
    ):
        found = (
            files.locator("span", has_text=text)
            .first.get_by_role("link")
            .evaluate_all("links => links.map((link) => link.getAttribute('href'))")
        )
        assert found == [f"/v1/jobs/{job}/{name}" for name in links]
    matched.goto("/#/")
    listed = matched.locator(f"a[href='#/jobs/{job}']")
    expect(listed).to_have_text("Match: human-standing.off and human-walking.off")
    listed.click()
    matched.get_by_role("heading").get_by_role("link", name="human-walking.off").click()
    expect(matched.get_by_text("Jobs of this shape")).to_be_visible()
    accessible(matched)
    expect(listed).to_be_visible()


def test_a_job_is_cancelled(page: Page, api: Api) -> None:
    page.goto("/")
    page.locator("#files").set_input_files([str(path) for path in FIGURES])
    expect(page.locator(".chips li")).to_have_count(2)
    page.get_by_label("Points", exact=True).fill("256")
    page.get_by_label("Metric").select_option("diffusion")
    page.get_by_role("button", name="Match", exact=True).click()
    bar = page.get_by_role("progressbar", name="Progress")
    bar.wait_for()
    expect(bar).to_have_attribute("aria-valuetext", re.compile(r"^\S.*, \d+ %$"))
    # What is announced has the state and the stage, and not each percentage.
    announced = page.get_by_role("main").locator("[aria-live], [role=status]")
    expect(announced.filter(has=bar)).to_have_count(0)
    expect(announced.and_(page.locator(".status"))).not_to_contain_text("%")
    page.get_by_role("button", name="Cancel").click()
    expect(page.locator("[data-state=cancelled]")).to_be_visible()
    expect(page.get_by_role("main")).to_be_focused()
    expect(bar).to_be_hidden()
    record = api.store.jobs.get(job_of(page))
    assert record is not None
    assert record.state.value == "cancelled"


def test_a_prototype_is_matched(page: Page, api: Api, upload: Callable[..., Json]) -> None:
    shapes = [upload(blob_file(2, seed=seed), f"chosen{seed}.off")["id"] for seed in (95, 96)]
    asked = {"shapes": shapes, "points": 6, "name": "<b>blob", "eigenpairs": 30}
    answer = httpx2.post(f"{api.url}/v1/prototypes", json=asked, timeout=60.0)
    page.goto(f"/#/jobs/{answer.json()['id']}")
    page.get_by_role("link", name="Match it with a shape").click()
    expect(page.locator(".chips li")).to_contain_text("<b>blob, version 1")
    first, second = (
        page.get_by_role("button", name=re.compile(f"(Choose|Chosen) chosen{seed}.off"))
        for seed in (95, 96)
    )
    for button in (second, first, second):
        button.click()
    for button, said in ((first, "Chosen"), (second, "Choose")):
        expect(button).to_have_text(said)
        expect(button).to_have_attribute("aria-pressed", str(said == "Chosen").lower())
    expect(page.locator(".chips li")).to_have_count(2)
    accessible(page)
    bar = page.locator(".chosen-bar")
    expect(bar).to_contain_text("2 chosen")
    page.evaluate("scrollTo(0, 0)")
    expect(bar).to_be_hidden()
    page.evaluate("scrollTo(0, document.body.scrollHeight)")
    bar.get_by_role("button", name="To the form").click()
    expect(page.get_by_label("Points", exact=True)).to_be_in_viewport()
    page.get_by_role("button", name="Match", exact=True).click()
    shown(page)
    result = result_of(page, api)
    assert result["source_kind"] == "prototype"
    assert rows(page) == pairs(result)
    # Its points are drawn on the shape they were chosen on, each in the colour of its partner.
    assert page.locator(".scene").count() == 2
    source, target = (scene.evaluate("s => s.data[1].marker.color") for scene in scenes(page))
    assert source == target
    assert len(set(source)) == 6
    expect(page.get_by_role("columnheader", name="Point of the prototype")).to_be_visible()
    named(page)
