"""Figures of prototypes, and the arrays that they are made of."""

import asyncio
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import isomatch
import numpy as np
import pytest
from scipy.sparse.csgraph import minimum_spanning_tree

from demo.stack import Stack
from solver.prototype import prototype_from_bytes
from tests.client._results.test_figures import marked_points, positions, traces
from tests.worker.families import family

POINTS = 8


@pytest.fixture(scope="module")
def client(stack: Stack) -> Iterator[isomatch.Client]:
    with isomatch.Client(stack.url) as client:
        yield client


@pytest.fixture(scope="module")
def shapes(client: isomatch.Client) -> list[isomatch.Shape]:
    """Five examples, and one more that nothing is learned from."""
    return [client.upload(data, file_type="off") for data in family(6, first=300)]


@pytest.fixture(scope="module")
def job(
    client: isomatch.Client, shapes: list[isomatch.Shape]
) -> isomatch.Job[isomatch.LearnedPrototype]:
    started = client.learn_prototype(
        shapes[:5], name="drawn", correspondence="shared_connectivity",
        points=POINTS, components=2, eigenpairs=30,
    )  # fmt: skip
    return started.wait(60)


def lines(figure: Any) -> Any:
    """The trace of the spanning tree."""
    (found,) = (trace for trace in traces(figure, "scatter3d") if trace.mode == "lines")
    return found


def test_points_of_a_prototype(
    client: isomatch.Client, job: isomatch.Job[isomatch.LearnedPrototype], tmp_path: Path
) -> None:
    made = job.result().prototype
    known = client.prototype_points(made)
    client.download_prototype(made, tmp_path / "drawn.npz")
    archive = (tmp_path / "drawn.npz").read_bytes()
    prototype = prototype_from_bytes(archive)
    np.testing.assert_array_equal(known.positions, prototype.positions)
    np.testing.assert_array_equal(known.vertex_ids, prototype.vertices)

    # Mean and spread of a mixture, by drawing from it.
    mixtures = prototype.distances[-1].mixtures
    rng = np.random.default_rng(0)
    for i, j in ((0, 1), (2, 6), (5, 7)):
        place = j * (j - 1) // 2 + i
        which = rng.choice(mixtures.weights.shape[1], 40_000, p=mixtures.weights[place])
        widths = np.sqrt(mixtures.covariances[place, which, 0, 0])
        drawn = rng.normal(mixtures.means[place, which, 0], widths)
        assert known.mean_distances[i, j] == pytest.approx(drawn.mean(), rel=0.02)
        assert known.spreads[j, i] == pytest.approx(drawn.std(), rel=0.03)
    for square in (known.mean_distances, known.spreads):
        np.testing.assert_array_equal(square, square.T)
        assert not square.diagonal().any()

    # The reference's surface, of which the points are vertices, or nearly.
    assert known.surface is not None
    mesh = prototype.surfaces[0].mesh()
    np.testing.assert_array_equal(known.surface.faces, mesh.faces)
    apart = known.positions[:, None] - known.surface.vertices
    assert np.linalg.norm(apart, axis=2).min(axis=1).max() < 1e-6
    with np.load(tmp_path / "drawn.npz", allow_pickle=False) as arrays:
        kept = {name: arrays[name] for name in arrays.files}
    elsewhere = io.BytesIO()
    np.savez(elsewhere, **{**kept, "surface0_vertices": 2 * kept["surface0_vertices"]})
    assert isomatch.PrototypePoints.from_bytes(elsewhere.getvalue()).surface is None
    old = io.BytesIO()
    np.savez(old, **{name: kept[name] for name in kept if "surface" not in name})
    assert isomatch.PrototypePoints.from_bytes(old.getvalue()).surface is None

    lengths = known.mean_distances[known.spanning_tree[:, 0], known.spanning_tree[:, 1]]
    assert lengths.sum() == pytest.approx(minimum_spanning_tree(known.mean_distances).sum())
    assert set(known.spanning_tree.ravel()) == set(range(POINTS))

    for damaged in (
        b"",
        b"no archive",
        archive[:-200],
        archive.replace(b"distances0", b"distances_"),
    ):
        with pytest.raises(ValueError, match="not the archive of a prototype"):
            isomatch.PrototypePoints.from_bytes(damaged)


def test_a_learned_prototype_is_drawn(
    client: isomatch.Client, job: isomatch.Job[isomatch.LearnedPrototype], tmp_path: Path
) -> None:
    learned = job.result()
    known = client.prototype_points(learned.prototype)
    figure = learned.plot()
    (points,) = marked_points(figure, "scene")
    np.testing.assert_array_equal(points[0], known.positions)
    assert len(set(points[1])) == POINTS
    (markers,) = (one for one in traces(figure, "scatter3d") if one.mode == "markers")
    assert markers.text == tuple(map(str, range(POINTS)))
    with np.errstate(invalid="ignore"):
        ratios = known.spreads / known.mean_distances
    (matrix,) = (trace for trace in figure.data if trace.type == "heatmap")
    np.testing.assert_allclose(matrix.z, ratios)
    # Lines and matrix have one colour axis.
    tree = known.spanning_tree
    ends = positions(lines(figure)).reshape(-1, 3, 3)
    np.testing.assert_array_equal(ends[:, :2], known.positions[tree])
    assert np.isnan(ends[:, 2]).all()
    values = np.asarray(lines(figure).line.color).reshape(-1, 3)
    np.testing.assert_allclose(
        values, np.repeat(ratios[tree[:, 0], tree[:, 1]][:, None], 3, axis=1)
    )
    assert matrix.coloraxis == lines(figure).line.coloraxis == "coloraxis"
    assert figure.layout.coloraxis.cmin == 0.0
    seen = figure.layout.scene.camera
    view = np.array([[way[axis] for axis in "xyz"] for way in (seen.up, seen.eye)])
    np.testing.assert_allclose(view, known.view[1:] * [[1.0], [1.3]])
    np.testing.assert_array_equal(known.view, learned.prototype.view)
    assert known.surface is not None
    (surface,) = traces(figure, "mesh3d")
    np.testing.assert_array_equal(
        np.column_stack([surface.i, surface.j, surface.k]), known.surface.faces
    )
    assert "drawn, version" in figure.layout.title.text
    assert repr(learned).startswith("<LearnedPrototype 'drawn', version")

    assert len(job.plot().data) == len(figure.data)
    learned.save(tmp_path / "kept.json")
    kept = isomatch.LearnedPrototype.from_json((tmp_path / "kept.json").read_bytes())
    with pytest.raises(ValueError, match=r"client.prototype_points\('p-"):
        kept.plot()
    for again in (kept.plot(known), known.plot()):
        assert [trace.type for trace in again.data] == [trace.type for trace in figure.data]


def test_a_match_with_a_prototype_is_drawn(
    client: isomatch.Client,
    job: isomatch.Job[isomatch.LearnedPrototype],
    shapes: list[isomatch.Shape],
) -> None:
    made = job.result().prototype
    match = client.match(made, shapes[5]).result()
    figure = match.plot()
    (source, colors), (target, same) = marked_points(figure)
    known, surface = client.prototype_points(made), client.geometry(shapes[5])
    np.testing.assert_array_equal(source, known.positions[match.pairs[:, 0]])
    np.testing.assert_array_equal(target, surface.positions(match.pairs[:, 1]))
    assert colors == same
    assert len(positions(lines(figure))) == 3 * (POINTS - 1)
    with pytest.raises(ValueError, match="give what is drawn"):
        match.plot(surface)
    with pytest.raises(ValueError, match="give what is drawn"):
        match.plot(surface, known)


def test_async(url: str, job: isomatch.Job[isomatch.LearnedPrototype]) -> None:
    async def program() -> None:
        async with isomatch.AsyncClient(url) as client:
            again = await client.job(job.id)
            learned = await again.result()
            figure = await again.plot()
            known = await client.prototype_points(learned.prototype.id)
            (points,) = marked_points(figure, "scene")
            np.testing.assert_array_equal(points[0], known.positions)

    asyncio.run(program())
