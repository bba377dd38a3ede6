"""Figures of prototypes, and the arrays that they are made of."""

import asyncio
import io
from collections.abc import Iterator
from pathlib import Path

import isomatch
import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import colormaps, pyplot
from matplotlib.axes import Axes
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection
from scipy.sparse.csgraph import minimum_spanning_tree

from demo.stack import Stack
from solver.prototype import prototype_from_bytes
from tests.client._results.test_plotting import drawn_points
from tests.worker.families import family

POINTS = 8


@pytest.fixture(autouse=True)
def no_display() -> Iterator[None]:
    mpl.use("Agg")
    yield
    pyplot.close("all")


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


def bones_of(axes: Axes) -> Line3DCollection:
    (bones,) = (part for part in axes.collections if isinstance(part, Line3DCollection))
    return bones


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

    lengths = known.mean_distances[known.bones[:, 0], known.bones[:, 1]]
    assert lengths.sum() == pytest.approx(minimum_spanning_tree(known.mean_distances).sum())
    assert set(known.bones.ravel()) == set(range(POINTS))

    for damaged in (
        b"",
        b"no archive",
        archive[:-200],
        archive.replace(b"distances0", b"distances_"),
    ):
        with pytest.raises(ValueError, match="no archive of a prototype"):
            isomatch.PrototypePoints.from_bytes(damaged)


def test_a_learned_prototype_is_drawn(
    client: isomatch.Client, job: isomatch.Job[isomatch.LearnedPrototype], tmp_path: Path
) -> None:
    learned = job.result()
    known = client.prototype_points(learned.prototype)
    figure = learned.plot(path=tmp_path / "prototype.png")
    body, matrix, _ = figure.axes
    (points,) = drawn_points(figure, [body])
    np.testing.assert_array_equal(points[0], known.positions)
    assert len(np.unique(points[1], axis=0)) == POINTS
    assert [
        text.get_text().strip() for text in body.texts if text.get_text().strip().isdigit()
    ] == [str(number) for number in range(POINTS)]
    # Lines have the colours that their distances have in the matrix.
    (image,) = matrix.images
    with np.errstate(invalid="ignore"):
        ratios = known.spreads / known.mean_distances
    drawn = image.get_array()
    assert drawn is not None
    np.testing.assert_allclose(np.ma.filled(drawn, np.nan), ratios)
    assert known.surface is not None
    (skin,) = (part for part in body.collections if isinstance(part, Poly3DCollection))
    assert len(skin._facecolor3d) == len(known.surface.faces)
    bones = bones_of(body)
    np.testing.assert_array_equal(np.array(bones._segments3d), known.positions[known.bones])
    told = colormaps["viridis"](image.norm(ratios[known.bones[:, 0], known.bones[:, 1]]))
    np.testing.assert_allclose(bones.get_color(), told)
    assert "drawn, version" in figure.get_suptitle()
    assert repr(learned).startswith("<LearnedPrototype 'drawn', version")

    job.plot(tmp_path / "again.svg")
    assert b"<svg" in (tmp_path / "again.svg").read_bytes()
    learned.save(tmp_path / "kept.json")
    kept = isomatch.LearnedPrototype.from_json((tmp_path / "kept.json").read_bytes())
    with pytest.raises(ValueError, match=r"client.prototype_points\('p-"):
        kept.plot()
    assert len(kept.plot(known).axes) == 3
    assert len(known.plot(tmp_path / "known.pdf").axes) == 3


def test_a_match_with_a_prototype_is_drawn(
    client: isomatch.Client,
    job: isomatch.Job[isomatch.LearnedPrototype],
    shapes: list[isomatch.Shape],
) -> None:
    made = job.result().prototype
    match = client.match(made, shapes[5]).result()
    figure = match.plot()
    (source, colors), (target, same) = drawn_points(figure)
    known, surface = client.prototype_points(made), client.geometry(shapes[5])
    np.testing.assert_array_equal(source, known.positions[match.pairs[:, 0]])
    np.testing.assert_array_equal(target, surface.positions(match.pairs[:, 1]))
    np.testing.assert_array_equal(colors, same)
    assert len(bones_of(figure.axes[0])._segments3d) == POINTS - 1
    with pytest.raises(ValueError, match="give what is drawn"):
        match.plot(surface)
    with pytest.raises(ValueError, match="give what is drawn"):
        match.plot(surface, known)


def test_async(url: str, job: isomatch.Job[isomatch.LearnedPrototype], tmp_path: Path) -> None:
    async def program() -> None:
        async with isomatch.AsyncClient(url) as client:
            again = await client.job(job.id)
            learned = await again.result()
            figure = await again.plot(tmp_path / "prototype.svg")
            known = await client.prototype_points(learned.prototype.id)
            (points,) = drawn_points(figure, figure.axes[:1])
            np.testing.assert_array_equal(points[0], known.positions)

    asyncio.run(program())
    assert b"<svg" in (tmp_path / "prototype.svg").read_bytes()
