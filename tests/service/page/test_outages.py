"""The page without workers or without an answer, and pages that are left before one arrives."""

from collections.abc import Iterator

import httpx2
import pytest
from playwright.sync_api import Browser, FilePayload, Page, Request, Route, expect

from service.standalone import EmbeddedServer
from tests.service.conftest import Api, idle_api, put_shapes
from tests.service.page.conftest import SMALL, job_of, opened


@pytest.fixture(scope="module")
def idle(server: EmbeddedServer) -> Iterator[Api]:
    """An API without a worker, which does not wait for one."""
    with idle_api(server, validation_wait=0) as api:
        yield api


@pytest.fixture
def page(browser: Browser, idle: Api) -> Iterator[Page]:
    with opened(browser, idle.url, viewport=SMALL) as tab:
        yield tab


def requested(idle: Api, path: str, body: dict[str, object]) -> str:
    """Id of a job that nobody runs."""
    answer = httpx2.post(f"{idle.url}/v1/{path}", json=body)
    assert answer.status_code == 202, answer.text
    job: str = answer.json()["id"]
    return job


def unanswered(_: Route) -> None:
    """Leave a request without an answer."""


def files(count: int) -> list[FilePayload]:
    return [{"name": f"{n}.off", "mimeType": "", "buffer": b"OFF # %d" % n} for n in range(count)]


def leave(page: Page) -> None:
    """Leave the start page, though files are being uploaded."""
    page.get_by_role("dialog").get_by_role("button", name="Leave").click()
    # A dialog that is closed has no role any more, but the page is left once it is removed.
    expect(page.locator("dialog")).to_have_count(0)


def test_a_start_page_that_is_left_does_nothing_more(page: Page, idle: Api) -> None:
    source, target = put_shapes(idle)
    job = requested(idle, "matches", {"source": source, "target": target})
    page.route(f"**/v1/shapes/{source}", unanswered)
    with page.expect_response(f"**/v1/shapes/{target}"):
        page.goto(f"/#/with/{source}/{target}")
    page.evaluate("job => { location.hash = `#/jobs/${job}` }", job)
    expect(page.locator("[data-state=queued]")).to_be_visible()
    assert page.url.endswith(f"#/jobs/{job}")
    # A file that is dropped leads to the start page that is shown then.
    dropped = page.evaluate_handle(
        """() => {
          const dropped = new DataTransfer();
          dropped.items.add(new File(['OFF'], 'dropped.off'));
          return dropped;
        }"""
    )
    page.dispatch_event("footer", "drop", {"dataTransfer": dropped})
    expect(page.locator(".uploads .name")).to_have_text("dropped.off")
    expect(page.locator(".uploads li")).to_contain_text("no worker is alive")
    # Files that wait for others to be uploaded are not sent.
    sent: list[Request] = []
    page.on("request", lambda asked: sent.append(asked) if asked.method == "POST" else None)
    page.goto("/#/nowhere")
    leave(page)
    page.goto("/#/")
    page.locator("#files").set_input_files(files(10))
    expect(page.locator(".uploads .name")).to_have_count(10)
    expect(page.locator(".uploads li").filter(has_text="no worker is alive")).to_have_count(4)
    page.evaluate("job => { location.hash = `#/jobs/${job}` }", job)
    leave(page)
    expect(page.locator("[data-state=queued]")).to_be_visible()
    assert page.url.endswith(f"#/jobs/{job}")
    assert len(sent) == 4


def test_the_list_of_shapes_outlasts_an_outage(page: Page, idle: Api) -> None:
    # The service is idle: its shapes are not in the listing.
    records = [{"id": shape, "name": "a.off", "vertices": 9} for shape in put_shapes(idle)]
    page.route(
        "**/v1/shapes?*",
        lambda route: route.fulfill(json={"items": records, "next_cursor": None}),
    )
    page.goto("/#/")
    listed = page.locator(".choose")
    expect(listed).to_have_count(2)
    page.route("**/v1/shapes*", lambda route: route.abort())
    with page.expect_request("**/v1/shapes?*"):
        page.locator("#files").set_input_files(files(1))
    expect(page.locator(".uploads").get_by_role("alert")).to_have_count(1)
    expect(page.get_by_role("alert")).to_have_count(1)
    expect(listed).to_have_count(2)
    # When the user comes back, they are listed again.
    page.unroute("**/v1/shapes*")
    records.pop()
    page.evaluate("window.dispatchEvent(new Event('focus'))")
    expect(listed).to_have_count(1)


def test_a_shape_is_shown_once_it_is_validated(page: Page, idle: Api) -> None:
    source, _ = put_shapes(idle)
    upload = httpx2.post(f"{idle.url}/v1/shapes", files={"file": ("new.off", b"OFF # new\n")})
    assert upload.status_code == 202
    shape = upload.headers["location"].rpartition("/")[2]

    def known(route: Route) -> None:
        record = httpx2.get(f"{idle.url}/v1/shapes/{source}").json()
        route.fulfill(json=record | {"id": shape, "name": "new.off"})

    for address, awaited, shown in (
        (f"/#/with/{source}/{shape}", "Waiting for a shape", page.locator(".chips li").last),
        (f"/#/shapes/{shape}", "Loading", page.get_by_role("heading", level=2).first),
    ):
        with page.expect_response(f"**/v1/shapes/{shape}"):
            page.goto(address)
        expect(page.get_by_text(awaited)).to_be_visible()
        expect(page.get_by_role("alert")).to_have_count(0)
        page.route(f"**/v1/shapes/{shape}", known)
        expect(shown).to_contain_text("new.off")
        expect(page.get_by_text(awaited)).to_have_count(0)
        page.unroute(f"**/v1/shapes/{shape}")


def test_a_job_waits_for_files_that_are_uploaded(page: Page, idle: Api) -> None:
    page.goto(f"/#/with/{'/'.join(put_shapes(idle))}")
    submit = page.get_by_role("button", name="Match", exact=True)
    expect(submit).to_have_attribute("aria-disabled", "false")
    page.locator("#files").set_input_files(files(5))
    expect(page.get_by_text("5 files are still uploading.", exact=True)).to_be_visible()
    expect(submit).to_have_attribute("aria-disabled", "true")
    # Who is asked, and stays, loses nothing.
    page.get_by_role("link", name="isomatch", exact=True).click()
    expect(page.get_by_role("dialog")).to_contain_text("5 files are still uploading.")
    page.keyboard.press("Escape")
    page.wait_for_url("**/#/with/**")
    expect(page.locator(".uploads .name")).to_have_count(5)
    page.get_by_role("link", name="isomatch", exact=True).click()
    leave(page)
    expect(page.locator(".uploads .name")).to_have_count(0)
    page.wait_for_url("**/#/")
    # Of many that arrive, few forms are made, and the structures are known.
    arrived: list[Request] = []

    def taken(route: Route) -> None:
        arrived.append(route.request)
        name = f"{len(arrived)}.off"
        route.fulfill(json={"id": name, "name": name, "vertices": 9, "warnings": []})

    page.route("**/v1/shapes", taken)
    page.route("**/v1/structures", unanswered)
    count = "() => { const set = history.replaceState.bind(history); window.forms = 0;"
    page.evaluate(f"{count} history.replaceState = (...a) => {{ window.forms++; set(...a); }}; }}")
    page.locator("#files").set_input_files(files(30))
    expect(page.get_by_text("30 chosen shapes")).to_be_visible()
    expect(page.get_by_text("Loading the metrics")).to_have_count(0, timeout=5_000)
    assert page.evaluate("window.forms") < 15


def test_an_upload_says_that_no_worker_is_ready(browser: Browser, server: EmbeddedServer) -> None:
    with (
        idle_api(server, validation_wait=60) as api,
        opened(browser, api.url, viewport=SMALL) as page,
    ):
        page.goto("/")
        page.locator("#files").set_input_files(files(1))
        # The answer to the upload waits for its validation.
        expect(page.locator(".uploads li")).to_contain_text("no worker is alive")
        page.goto("/#/nowhere")
        leave(page)


def test_a_service_that_does_not_answer_is_asked_again(page: Page, idle: Api) -> None:
    source, _ = put_shapes(idle)
    page.route(f"**/v1/shapes/{source}", lambda route: route.abort())
    page.goto(f"/#/shapes/{source}")
    expect(page.get_by_role("alert")).to_contain_text("does not answer")
    page.unroute(f"**/v1/shapes/{source}")
    page.get_by_role("button", name="Try again").click()
    expect(page.get_by_role("link", name="Match it")).to_be_visible()
    # An upload is sent again.
    page.goto("/#/")
    page.route("**/v1/shapes", lambda route: route.abort())
    page.locator("#files").set_input_files(files(2))
    expect(page.get_by_role("alert")).to_have_count(2)
    expect(page.get_by_role("alert").first).to_contain_text("does not answer")
    expect(page.locator(".uploads li").first).to_contain_text("not sent")
    expect(page.get_by_text("0 of 2 files uploaded, 2 not sent", exact=True)).to_be_visible()
    page.get_by_role("button", name="Dismiss").first.click()
    page.unroute("**/v1/shapes")
    page.get_by_role("button", name="Try again").click()
    expect(page.locator(".uploads li")).to_contain_text("no worker is alive")
    page.goto("/#/nowhere")
    leave(page)
    expect(page.get_by_role("button", name="Try again")).to_have_count(0)


def test_a_form_without_its_fields_is_not_sent(page: Page, idle: Api) -> None:
    page.route("**/v1/structures", lambda route: route.abort())
    page.goto(f"/#/with/{'/'.join(put_shapes(idle))}")
    submit = page.get_by_role("button", name="Match", exact=True)
    expect(page.get_by_role("alert")).to_contain_text("does not answer")
    expect(submit).to_have_attribute("aria-disabled", "true")
    submit.dispatch_event("click")
    page.unroute("**/v1/structures")
    page.get_by_role("button", name="Try again").click()
    expect(page.get_by_label("Points", exact=True)).to_be_visible()
    assert "#/with/" in page.url
    submit.click()
    page.wait_for_url("**/#/jobs/*")


def test_a_request_whose_answer_is_lost_makes_one_job(page: Page, idle: Api) -> None:
    page.goto(f"/#/with/{'/'.join(put_shapes(idle))}")
    made: list[str] = []

    def lose(route: Route) -> None:
        made.append(route.fetch().json()["id"])
        route.abort()

    page.route("**/v1/matches", lose)
    submit = page.get_by_role("button", name="Match", exact=True)
    submit.click()
    expect(page.get_by_role("alert")).to_contain_text("does not answer")
    page.unroute("**/v1/matches")
    submit.click()
    page.wait_for_url("**/#/jobs/*")
    assert [job_of(page)] == made
    # It was answered: the same contents make another job.
    page.go_back()
    submit.click()
    page.wait_for_url("**/#/jobs/*")
    assert [job_of(page)] != made
    # Who leaves before the answer stays where they are.
    held: list[Route] = []
    page.route("**/v1/matches", lambda route: held.append(route))
    page.go_back()
    with page.expect_request("**/v1/matches"):
        submit.click()
    page.evaluate("location.hash = '#/nowhere'")
    expect(page.get_by_text("This address does not exist")).to_be_visible()
    with page.expect_request_finished(lambda asked: asked.url.endswith("/v1/matches")):
        held[0].continue_()
    page.evaluate("new Promise((resolve) => setTimeout(resolve, 100))")
    assert page.url.endswith("#/nowhere")


def test_a_lost_connection_is_said_until_it_is_back(page: Page, idle: Api) -> None:
    source, target = put_shapes(idle)
    job = requested(idle, "matches", {"source": source, "target": target})
    page.route("**/events", lambda route: route.abort())
    page.goto(f"/#/jobs/{job}")
    status = page.locator(".status")
    expect(status).to_have_text("Connection lost; trying again.")
    page.unroute("**/events")
    # So a proxy answers while the service behind it restarts.
    with page.expect_response(lambda answer: answer.status == 502):
        page.route("**/events", lambda route: route.fulfill(status=502))
    page.unroute("**/events")
    expect(status).to_have_text("Waiting: no worker is alive.")
    assert page.get_by_role("alert").count() == 0
    page.route(f"**/v1/jobs/{job}", lambda route: route.abort())
    page.get_by_role("button", name="Cancel").click()
    expect(page.get_by_role("alert")).to_contain_text("does not answer")
    expect(status).to_have_text("Waiting: no worker is alive.")


def test_a_dead_connection_is_noticed(page: Page, idle: Api) -> None:
    source, target = put_shapes(idle)
    job = requested(idle, "matches", {"source": source, "target": target})
    page.clock.install()
    with page.expect_response("**/events"):
        page.goto(f"/#/jobs/{job}")
    status = page.locator(".status")
    expect(status).to_have_text("Waiting: no worker is alive.")
    page.route(f"**/v1/jobs/{job}", lambda route: route.abort())
    page.get_by_role("button", name="Cancel").click()
    expect(page.get_by_role("alert")).to_contain_text("No answer")
    # Nothing has arrived for so long, by the clock of the page.
    page.clock.fast_forward(36_000)
    expect(status).to_have_text("Connection lost; trying again.")
    page.clock.fast_forward(1_000)
    expect(status).to_have_text("Waiting: no worker is alive.")
    expect(page.get_by_role("alert")).to_have_count(0)
    page.route(f"**/v1/shapes/{source}", unanswered)
    with page.expect_request(f"**/v1/shapes/{source}"):
        page.goto(f"/#/shapes/{source}")
    page.clock.fast_forward(41_000)
    expect(page.get_by_role("alert")).to_contain_text("has not answered for 40 s")


def test_a_cancelled_job_is_requested_again(page: Page, idle: Api) -> None:
    shapes = put_shapes(idle)
    job = requested(idle, "dissimilarities", {"shapes": shapes, "points": 3})
    page.goto(f"/#/jobs/{job}")
    # What is computed is said, before there is a result.
    title = f"Comparison: {', '.join(shape[:8] for shape in shapes)}"
    expect(page.locator("[data-state] h2")).to_have_text(title)
    expect(page).to_have_title(f"{title} – isomatch")
    page.get_by_role("button", name="Cancel").click()
    # They are in no list, which names are taken from.
    expect(page.get_by_text(f"Shapes: {', '.join(shape[:8] for shape in shapes)}")).to_be_visible()
    page.get_by_role("link", name="Request it again").click()
    expect(page.locator(".chips li")).to_have_count(2)
    expect(page.get_by_role("radio", name="Compare")).to_be_checked()
    expect(page.get_by_role("button", name="Compare", exact=True)).to_be_visible()
    expect(page.get_by_label("Points", exact=True)).to_have_value("3")


def test_recent_jobs_are_kept_up_to_date(page: Page, idle: Api) -> None:
    source, target = put_shapes(idle)
    asked: dict[str, object] = {"source": source, "target": target}
    # The first is on the second page of the list.
    jobs = [requested(idle, "matches", asked) for _ in range(9)]
    jobs = [jobs[0], jobs[-1]]
    page.clock.install()
    page.goto("/#/")
    page.get_by_role("button", name="More").first.click()
    first, second = (page.locator(f"[data-job='{job}']") for job in jobs)
    expect(second.locator(".state")).to_have_text("waiting")
    # Links of the same text are told apart, and large enough for fingers.
    told = [line.get_by_role("link").get_attribute("aria-describedby") for line in (first, second)]
    assert told == [f"about-{job}" for job in jobs]
    expect(page.locator(f"#about-{jobs[1]}")).to_contain_text("waiting")
    box = second.get_by_role("link").bounding_box()
    assert box is not None
    assert box["height"] >= 24
    second.get_by_role("link").focus()
    httpx2.delete(f"{idle.url}/v1/jobs/{jobs[0]}").raise_for_status()
    page.clock.fast_forward(4_000)
    expect(first.locator(".state")).to_have_text("cancelled")
    expect(second.get_by_role("link")).to_be_focused()
    # Also what was requested elsewhere, when the user comes back.
    newer = requested(idle, "matches", {**asked, "points": 9})
    page.evaluate("window.dispatchEvent(new Event('focus'))")
    expect(page.locator("[data-job]").first).to_have_attribute("data-job", newer)
    expect(page.locator("[data-job]").first).to_contain_text("points 9")


def test_a_cancelled_batch_shows_what_was_kept(page: Page, idle: Api) -> None:
    source, target = put_shapes(idle)
    page.goto(f"/#/jobs/{requested(idle, 'batches', {'source': source, 'targets': [target]})}")
    page.get_by_role("button", name="Cancel").click()
    expect(page.get_by_role("table")).to_contain_text("0 of 1 matches have succeeded")
    expect(page.locator("h2", has_text="1 match with")).to_be_visible()
    expect(page.locator("tbody .state")).to_have_text("cancelled")
