"""Landmarks carried by both clients, against the running service."""

import asyncio
from collections.abc import Iterator
from contextlib import contextmanager

import anyio
import httpx2
import isomatch
import numpy as np
import pytest
import trimesh

from tests.client.shapes import LASTING, blob, moved

Pair = tuple[isomatch.Shape, isomatch.Shape]
PLACES = blob(trimesh.creation.icosphere(subdivisions=1).vertices[::5])
GIVEN = isomatch.LandmarkSet.of(
    [(f"p{row}", None if row == 1 else place) for row, place in enumerate(PLACES.tolist())]
)


def error(found: isomatch.CarriedLandmarks, size: float) -> float:
    """The greatest distance from where the landmarks are, over √area."""
    apart = np.linalg.norm(found.positions - moved(PLACES), axis=1)[GIVEN.present]
    return float(apart.max() / size)


def test_landmarks_of_one_and_of_two_templates(client: isomatch.Client, pair: Pair) -> None:
    source, target = pair
    surface = client.geometry(target)
    a, b, c = np.moveaxis(surface.vertices[surface.faces], 1, 0)
    size = float(np.sqrt(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()))
    template = isomatch.LandmarkTemplate(source, GIVEN)
    found = client.landmarks([template], target).result()
    assert found.labels == GIVEN.labels
    assert error(found, size) < 0.05
    assert np.isnan(found.confidence).tolist() == (~GIVEN.present).tolist()
    assert (found.round_trip[GIVEN.present] < 0.05).all()

    backwards = isomatch.LandmarkSet(GIVEN.labels[::-1], moved(GIVEN.positions)[::-1])
    itself = isomatch.LandmarkTemplate(target.id, backwards)
    both = client.landmarks([template, itself], target, points=8).result()
    assert error(both, size) < 0.05
    assert (both.spread[GIVEN.present] < 0.05).all()
    assert both.labels == GIVEN.labels
    assert both.probabilities.shape == (2,)


def test_the_asynchronous_client_finds_the_same(url: str, pair: Pair) -> None:
    template = isomatch.LandmarkTemplate(pair[0], GIVEN)

    async def asked() -> isomatch.CarriedLandmarks:
        async with isomatch.AsyncClient(url) as client:
            return await (await client.landmarks([template], pair[1])).result(timeout=240)

    with isomatch.Client(url) as client:
        expected = client.landmarks([template], pair[1]).result()
    np.testing.assert_array_equal(anyio.run(asked).positions, expected.positions)


class Counting(httpx2.HTTPTransport):
    """A network that notes what is requested."""

    def __init__(self) -> None:
        super().__init__()
        self.requested: list[tuple[str, str]] = []

    def handle_request(self, request: httpx2.Request) -> httpx2.Response:
        self.requested.append((request.method, request.url.path))
        return super().handle_request(request)


def test_a_job_carries_once_and_loads_neither_maps_nor_surfaces(url: str, pair: Pair) -> None:
    template = isomatch.LandmarkTemplate(pair[0], GIVEN)
    network = Counting()
    with isomatch.Client(url, transport=network) as client:
        job = client.landmarks([template], pair[1])
        first, again = job.result(timeout=240), job.result(timeout=240)
    np.testing.assert_array_equal(first.positions, again.positions)
    assert network.requested.count(("POST", "/v1/transfers")) == 1
    assert ("GET", f"/v1/jobs/{job.job_ids[0]}/result") not in network.requested
    assert not [path for _, path in network.requested if path.endswith(("geometry", "npz"))]


def test_several_specimens_run_at_the_same_time(client: isomatch.Client, pair: Pair) -> None:
    template = isomatch.LandmarkTemplate(pair[0], GIVEN)
    running = client.landmarks([template], pair[1], **LASTING)
    quick = client.landmarks([template], pair[1])
    assert not client.job(running.job_ids[0]).finished
    running.cancel()
    assert np.isfinite(quick.result(timeout=240).positions[GIVEN.present]).all()


def test_landmarks_of_one_template_that_are_all_missing(
    client: isomatch.Client, pair: Pair
) -> None:
    none = isomatch.LandmarkSet(GIVEN.labels, np.full_like(GIVEN.positions, np.nan))
    templates = [isomatch.LandmarkTemplate(pair[0], one) for one in (none, GIVEN)]
    both = client.landmarks(templates, pair[1]).result(timeout=240)
    alone = client.landmarks(templates[1:], pair[1]).result(timeout=240)
    np.testing.assert_array_equal(both.positions, alone.positions)
    np.testing.assert_allclose(both.confidence, alone.confidence)


@pytest.mark.parametrize("factors", [[1e3, 1e3, 1e3], [-1.0, -1.0, 1.0]])
def test_landmarks_in_a_wrong_unit_or_system_are_refused(
    client: isomatch.Client, pair: Pair, factors: list[float]
) -> None:
    wrong = isomatch.LandmarkSet(GIVEN.labels, GIVEN.positions * factors)
    template = isomatch.LandmarkTemplate(pair[0], wrong)
    with pytest.raises(isomatch.WrongCoordinates, match="landmarks are far from the surface"):
        client.landmarks([template], pair[1]).result(timeout=240)


def test_a_transfer_takes_landmarks_in_space(client: isomatch.Client, pair: Pair) -> None:
    """Also with labels that the service does not take."""
    labels = ("a\nb", *GIVEN.labels[1:-1], 300 * "a")
    match = client.match(*pair, dense=True).wait(timeout=240)
    given = isomatch.LandmarkSet(labels, GIVEN.positions)
    found = client.transfer(match, what="landmarks", landmarks=given).result(timeout=240)
    assert found.landmarks is not None
    known = [one.label for one in found.landmarks]
    assert known == [None, *GIVEN.labels[1:-1], None]
    carried = client.landmarks([isomatch.LandmarkTemplate(pair[0], GIVEN)], pair[1])
    positions = [one.position or 3 * (np.nan,) for one in found.landmarks]
    np.testing.assert_allclose(positions, carried.result(timeout=240).positions)


def test_matches_are_cancelled_together(client: isomatch.Client, pair: Pair) -> None:
    template = isomatch.LandmarkTemplate(pair[0], GIVEN)
    running = client.landmarks([template, template], pair[1], **LASTING)
    running.cancel()
    with pytest.raises(isomatch.JobCancelled):
        running.result(timeout=240)
    assert len(running.job_ids) == 2


def test_what_cannot_be_carried_is_refused(client: isomatch.Client, pair: Pair) -> None:
    template = isomatch.LandmarkTemplate(pair[0], GIVEN)
    with pytest.raises(ValueError, match="at least one template"):
        client.landmarks([], pair[1])
    with pytest.raises(TypeError, match="no parameter 'simplify'"):
        client.landmarks([template], pair[1], simplify=500)
    with pytest.raises(TypeError, match="'pints'") as refusal:
        client.landmarks([template], pair[1], pints=8)  # type: ignore[call-arg]
    assert refusal.value.__context__ is None
    before = {job.id for job in client.jobs() if not job.finished}
    unknown = isomatch.LandmarkTemplate(32 * "0", GIVEN)
    with pytest.raises(isomatch.UnknownShape):
        client.landmarks([template, unknown], pair[1], **LASTING)
    left = [job for job in client.jobs() if not job.finished and job.id not in before]
    assert all(job.wait(timeout=240).state == "cancelled" for job in left)


SECOND = 2
"""Match whose answer does not come."""


class Interrupted(httpx2.HTTPTransport):
    """A network during whose second answer to a match Ctrl-C is pressed."""

    matches = 0

    def handle_request(self, request: httpx2.Request) -> httpx2.Response:
        response = super().handle_request(request)
        self.matches += request.url.path == "/v1/matches"
        if self.matches == SECOND and request.method == "POST":
            response.close()
            raise KeyboardInterrupt
        return response


class Stalled(httpx2.AsyncHTTPTransport):
    """A network on which the second answer to a match does not come."""

    def __init__(self) -> None:
        super().__init__()
        self.matches, self.stalled = 0, anyio.Event()

    async def handle_async_request(self, request: httpx2.Request) -> httpx2.Response:
        response = await super().handle_async_request(request)
        self.matches += request.url.path == "/v1/matches"
        if self.matches == SECOND and not self.stalled.is_set():
            await response.aclose()
            self.stalled.set()
            await anyio.sleep_forever()
        return response


@contextmanager
def two_cancelled_jobs(client: isomatch.Client) -> Iterator[None]:
    before = {job.id for job in client.jobs()}
    yield
    new = [job for job in client.jobs() if job.id not in before]
    assert [job.wait(timeout=240).state for job in new] == ["cancelled"] * 2


def test_ctrl_c_between_two_matches_cancels_both(
    url: str, client: isomatch.Client, pair: Pair
) -> None:
    template = isomatch.LandmarkTemplate(pair[0], GIVEN)
    with (
        two_cancelled_jobs(client),
        isomatch.Client(url, transport=Interrupted()) as hurried,
        pytest.raises(KeyboardInterrupt),
    ):
        hurried.landmarks([template] * 3, pair[1], **LASTING)


@pytest.mark.parametrize("backend", ["asyncio", "trio"])
def test_a_cancelled_task_cancels_both_matches(
    url: str, client: isomatch.Client, pair: Pair, backend: str
) -> None:
    template = isomatch.LandmarkTemplate(pair[0], GIVEN)

    async def program() -> None:
        network = Stalled()
        async with isomatch.AsyncClient(url, transport=network) as stalled:

            async def start() -> None:
                await stalled.landmarks([template] * 3, pair[1], **LASTING)

            async with anyio.create_task_group() as tasks:
                tasks.start_soon(start)
                await network.stalled.wait()
                tasks.cancel_scope.cancel()

    with two_cancelled_jobs(client):
        anyio.run(program, backend=backend)


def test_a_cancelled_task_of_asyncio_cancels_both_matches(
    url: str, client: isomatch.Client, pair: Pair
) -> None:
    template = isomatch.LandmarkTemplate(pair[0], GIVEN)

    async def program() -> None:
        network = Stalled()
        async with isomatch.AsyncClient(url, transport=network) as stalled:
            start = stalled.landmarks([template] * 3, pair[1], **LASTING)
            task = asyncio.create_task(start)
            await network.stalled.wait()
            task.cancel()
            with pytest.raises(asyncio.CancelledError):
                await task

    with two_cancelled_jobs(client):
        asyncio.run(program())
