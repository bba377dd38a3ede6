"""A batch on the page: its matches, what is known of each, and links to them."""

from collections.abc import Callable

import httpx2
from playwright.sync_api import FilePayload, Page, expect

from tests.client.shapes import LASTING
from tests.service.conftest import Api, Json
from tests.service.page.conftest import PATIENCE, result_of
from tests.worker.figures import blob_file


def blobs(upload: Callable[..., Json], subdivisions: int = 3) -> list[str]:
    return [upload(blob_file(subdivisions, seed))["id"] for seed in range(3)]


def test_the_first_of_several_shapes_is_matched_with_the_others(
    page: Page, api: Api, upload: Callable[..., Json]
) -> None:
    ids = blobs(upload)
    page.goto(f"/#/with/{'/'.join(ids[:1])}")
    # The same files under other names, which the matches have as well.
    files: list[FilePayload] = [
        {"name": f"again{seed}.off", "mimeType": "", "buffer": blob_file(seed=seed)}
        for seed in (1, 2)
    ]
    page.locator("#files").set_input_files(files)
    expect(page.locator(".chips li")).to_have_count(3)
    page.get_by_label("Batch: match the first").check()
    points = page.get_by_label("Points", exact=True)
    points.fill("2")
    page.get_by_role("button", name="Match all").click()
    expect(page.locator("#error-points")).to_contain_text("greater than or equal to 3")
    points.fill("8")
    page.get_by_role("button", name="Match all").click()
    page.wait_for_url("**/#/jobs/*")
    expect(page.get_by_role("table")).to_contain_text("2 of 2 matches", timeout=PATIENCE)
    result = result_of(page, api)
    assert result["source"] == ids[0]
    assert [one["target"] for one in result["matches"]] == ids[1:]
    assert result["source_name"] == "mesh.off"
    assert [one["target_name"] for one in result["matches"]] == ["again1.off", "again2.off"]
    assert result["parameters"]["points"] == 8


def test_its_matches_are_listed(
    page: Page, http: httpx2.Client, upload: Callable[..., Json]
) -> None:
    source, target, _ = blobs(upload)
    gone = upload(blob_file(seed=88), "gone.off")["id"]
    body = {"source": source, "targets": [target, gone], "target_names": ["<b>one</b>", None]}
    job = http.post("/v1/batches", json={**body, "points": 8, "eigenpairs": 40}).json()
    page.goto(f"/#/jobs/{job['id']}")
    expect(page.get_by_role("table")).to_contain_text("2 of 2 matches", timeout=PATIENCE)
    rows = page.locator("tbody tr")
    expect(rows).to_have_count(2)
    expect(rows.first).to_contain_text("<b>one</b>")
    expect(rows.first).to_contain_text("confidence")
    expect(rows.last).to_contain_text("gone.off")
    expect(page.get_by_role("columnheader", name="Distortion of distances")).to_be_visible()
    page.get_by_role("link", name="<b>one</b>").click()
    page.wait_for_url(f"**/#/jobs/{job['id']}-1")
    page.locator("[data-drawn]").wait_for(timeout=PATIENCE)
    expect(page.get_by_role("heading", name="mesh.off and <b>one</b>")).to_be_visible()
    expect(page.get_by_role("link", name="Match again")).to_be_visible()
    http.delete(f"/v1/shapes/{gone}").raise_for_status()
    page.goto(f"/#/jobs/{job['id']}-2")
    expect(page.get_by_role("heading", name="mesh.off and gone.off")).to_be_visible()
    expect(page.get_by_text("A shape is no longer kept")).to_be_visible()
    expect(page.get_by_role("link", name="Match again")).to_have_count(0)


def test_a_match_that_waits_is_cancelled_alone(
    page: Page, http: httpx2.Client, upload: Callable[..., Json]
) -> None:
    """The matches are listed at once, although none ends."""
    # With fewer vertices, the first match may end before the page is loaded.
    source, *targets = blobs(upload, 5)
    body = {"source": source, "targets": targets * 2, "target_names": ["a", "b", "c", "d"]}
    job = http.post("/v1/batches", json={**body, **LASTING}).json()
    try:
        page.goto(f"/#/jobs/{job['id']}")
        expect(page.get_by_role("table")).to_contain_text("0 of 4 matches", timeout=10_000)
        page.get_by_role("link", name="d", exact=True).click()
        expect(page.get_by_text("Waiting for its turn in the batch.")).to_be_visible()
        page.get_by_role("button", name="Cancel").click()
        expect(page.get_by_text("Cancelled. Requested")).to_be_visible()
        page.get_by_role("link", name="Back to the batch").click()
        expect(page.locator("tbody tr").last).to_contain_text("cancelled")
        # What changes later is shown as well.
        http.delete(f"/v1/jobs/{job['id']}-3").raise_for_status()
        expect(page.get_by_role("table")).to_contain_text("2 of 4 matches")
        expect(page.locator("tbody tr").nth(2)).to_contain_text("cancelled")
    finally:
        http.delete(job["links"]["self"])
