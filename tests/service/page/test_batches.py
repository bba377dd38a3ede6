"""A batch on the page: its matches, what is known of each, and links to them."""

from collections.abc import Callable

import httpx2
from playwright.sync_api import Page, expect

from tests.service.conftest import Json
from tests.service.page.conftest import PATIENCE
from tests.worker.figures import blob_file


def test_its_matches_are_listed(
    page: Page, http: httpx2.Client, upload: Callable[..., Json]
) -> None:
    source = upload(blob_file())["id"]
    targets = [upload(blob_file(seed=seed))["id"] for seed in (1, 2)]
    body = {"source": source, "targets": targets, "target_names": ["<b>one</b>", None]}
    job = http.post("/v1/batches", json={**body, "points": 8, "eigenpairs": 40}).json()
    page.goto(f"/#/jobs/{job['id']}")
    expect(page.get_by_role("table")).to_contain_text("2 of 2 matches", timeout=PATIENCE)
    rows = page.locator("tbody tr")
    expect(rows).to_have_count(2)
    expect(rows.first).to_contain_text("<b>one</b>")
    expect(rows.first).to_contain_text("confidence")
    expect(rows.last).to_contain_text("mesh.off")
    page.get_by_role("link", name="<b>one</b>").click()
    page.wait_for_url(f"**/#/jobs/{job['id']}-1")
    page.locator("[data-drawn]").wait_for(timeout=PATIENCE)
