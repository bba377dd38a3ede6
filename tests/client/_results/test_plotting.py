"""Figures of results, drawn without a display."""

import asyncio
import struct
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx2
import isomatch
import matplotlib as mpl
import numpy as np
import pytest
from isomatch._results import Scene, View, place_colors, plot_scenes, surface_colors
from matplotlib import pyplot
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Path3DCollection, Poly3DCollection

from tests.client.shapes import blob_meshes

Pair = tuple[isomatch.Shape, isomatch.Shape]


@pytest.fixture(autouse=True)
def no_display() -> Iterator[None]:
    mpl.use("Agg")
    yield
    pyplot.close("all")


def drawn_points(
    figure: Figure, parts: list[Axes] | None = None
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Positions and colours of the points in each part of a figure, or in some of them."""
    found = []
    for axes in parts or figure.axes:
        (points,) = (part for part in axes.collections if isinstance(part, Path3DCollection))
        found.append(
            (np.column_stack(points._offsets3d), np.asarray(PathCollection.get_facecolor(points)))
        )
    return found


def test_the_geometry_has_the_vertices_of_the_file(client: isomatch.Client, pair: Pair) -> None:
    for shape, mesh in zip(pair, blob_meshes(), strict=True):
        geometry = client.geometry(shape)
        assert geometry.faces.shape == mesh.faces.shape
        assert geometry.colors is None
        numbers = np.arange(len(mesh.vertices))
        np.testing.assert_allclose(geometry.positions(numbers), mesh.vertices, atol=1e-6)
        assert geometry.positions(mesh.faces).shape == (*mesh.faces.shape, 3)
        with pytest.raises(ValueError, match="no vertex 642"):
            geometry.positions([0, 642])


def test_geometry_has_colours_and_only_vertices_of_faces(client: isomatch.Client) -> None:
    points = np.vstack([np.full((2, 3), 9.0), np.eye(3)])
    colors = np.arange(15, dtype=np.uint8).reshape(5, 3)
    geometry = client.geometry(client.upload((points, [[2, 3, 4]], colors)))
    np.testing.assert_array_equal(geometry.vertex_ids, [2, 3, 4])
    assert geometry.colors is not None
    np.testing.assert_array_equal(geometry.colors, colors[2:])
    np.testing.assert_allclose(geometry.positions([4, 2]), points[[4, 2]], atol=1e-7)
    with pytest.raises(ValueError, match="no vertex 1"):
        geometry.positions([1])


@pytest.mark.parametrize(
    "data", [b"", b"OFF", b"isogeom1" + struct.pack("<3I4x4d", 3, 1, 0, *[0] * 4)]
)
def test_invalid_geometry(data: bytes) -> None:
    with pytest.raises(ValueError, match="geometry"):
        isomatch.Geometry.from_bytes(data)


def test_a_match_is_drawn(client: isomatch.Client, pair: Pair, tmp_path: Path) -> None:
    match = client.match(*pair, points=8, coarse_points=6).result()
    figure = match.plot()
    match.plot(path=tmp_path / "match.pdf")
    assert (tmp_path / "match.pdf").read_bytes().startswith(b"%PDF")
    (source, colors), (target, same) = drawn_points(figure)
    first, second = blob_meshes()
    np.testing.assert_allclose(source, first.vertices[match.pairs[:, 0]], atol=1e-6)
    np.testing.assert_allclose(target, second.vertices[match.pairs[:, 1]], atol=1e-6)
    np.testing.assert_array_equal(colors, same)
    assert len(np.unique(colors, axis=0)) == 8
    for axes in figure.axes:
        (skin,) = (part for part in axes.collections if isinstance(part, Poly3DCollection))
        assert len(skin.get_facecolor()) == 1280

    match.save(tmp_path / "match.json")
    kept = isomatch.Match.from_json((tmp_path / "match.json").read_bytes())
    with pytest.raises(ValueError, match=rf"client.geometry\('{match.source}'\)"):
        kept.plot()
    again = kept.plot(*map(client.geometry, kept.drawn_ids()))
    np.testing.assert_array_equal(drawn_points(again)[1][0], target)
    # The file has to be named: what comes first is what is drawn.
    wrong: Any = "match.png"
    with pytest.raises(TypeError, match="path="):
        match.plot(wrong)


def test_refined_points_are_drawn_where_they_are(client: isomatch.Client, pair: Pair) -> None:
    job = client.match(*pair, points=8, coarse_points=6, refine="gmds").wait()
    match = job.result()
    assert match.refinement is not None
    places = match.refinement.refined_positions(blob_meshes()[1].vertices)
    np.testing.assert_allclose(drawn_points(job.plot())[1][0], places, atol=1e-6)


def test_alternatives_are_drawn(client: isomatch.Client, pair: Pair, tmp_path: Path) -> None:
    job = client.match(*pair, points=8, coarse_points=6, refine="gmds").wait()
    match = job.result()
    count = len(match.alternatives)
    assert count
    assert match.refinement is not None
    vertices = blob_meshes()[1].vertices
    for which, answer in enumerate((match, *match.alternatives)):
        places = vertices[answer.pairs[:, 1]]
        if match.refinement.hypothesis == which:
            places = match.refinement.refined_positions(vertices)
        figure = match.plot(alternative=which)
        np.testing.assert_allclose(drawn_points(figure)[1][0], places, atol=1e-6)
        assert f"{answer.energy:.4g}" in figure.get_suptitle()
    np.testing.assert_array_equal(
        drawn_points(job.plot(alternative=1))[1][0],
        drawn_points(match.plot(alternative=1))[1][0],
    )
    for wrong in (-1, count + 1):
        with pytest.raises(ValueError, match=f"it has {count}, numbered from 1"):
            match.plot(alternative=wrong)
    job.save_picture(tmp_path / "other.png", alternative=1)
    assert (tmp_path / "other.png").read_bytes() == job.picture(alternative=1) != job.picture()
    with pytest.raises(isomatch.InvalidRequest, match=f"it has {count}, numbered from 1"):
        job.picture(alternative=count + 1)


def skin_colors(axes: Axes) -> np.ndarray:
    """Colours of the triangles of a surface, without its light: shares of their sum."""
    (skin,) = (part for part in axes.collections if isinstance(part, Poly3DCollection))
    colors = np.asarray(skin._facecolor3d)[:, :3]
    shares: np.ndarray = colors / colors.sum(axis=1, keepdims=True)
    return shares


def test_a_dense_map_is_drawn(client: isomatch.Client, pair: Pair, tmp_path: Path) -> None:
    match = client.match(*pair, points=8, coarse_points=6, dense=True, eigenpairs=30).result()
    assert match.dense is not None
    figure = match.plot(path=tmp_path / "dense.png")
    source, target = map(client.geometry, pair)
    # A vertex has the colour of the one it goes to: so has each triangle the mean of its corners'.
    there = surface_colors(target.vertices)
    image = np.zeros(len(source.vertices), dtype=np.int64)
    image[source.rows(match.dense.source)] = target.rows(match.dense.target)
    for axes, colors, faces in (
        (figure.axes[0], there[image], source.faces),
        (figure.axes[1], there, target.faces),
    ):
        expected = colors[faces].mean(axis=1)
        expected /= expected.sum(axis=1, keepdims=True)
        np.testing.assert_allclose(skin_colors(axes), expected, atol=1e-6)
    assert len(np.unique(np.round(there[image], 6), axis=0)) > 300
    (_, colors), (_, same) = drawn_points(figure)
    np.testing.assert_array_equal(colors, same)

    # What no map reaches is gray, and an alternative's map is drawn with its pairs.
    half = match.dense.model_copy(
        update={
            "source": match.dense.source[:100],
            "target": match.dense.target[:100],
            "hypothesis": 1,
        }
    )
    assert match.alternatives
    other = match.model_copy(update={"dense": half}).plot(source, target)
    places = source.positions(match.alternatives[0].pairs[:, 0])
    np.testing.assert_allclose(drawn_points(other)[0][0], places)
    left_out = ~np.isin(source.vertex_ids[source.faces], half.source).any(axis=1)
    assert left_out.sum() > 500
    np.testing.assert_allclose(skin_colors(other.axes[0])[left_out], 1 / 3, atol=1e-6)


def test_targets_are_turned_as_their_sources_stand() -> None:
    rng = np.random.default_rng(8)
    here = rng.normal(size=(60, 3)) * [1.0, 3.0, 0.4]
    here[:20, 1] = here[:, 1].min()
    angle = 0.7
    cosine, sine = np.cos(angle), np.sin(angle)
    turn = np.array([[cosine, 0.0, sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]])
    there = here @ turn.T + [5.0, 0.0, 1.0]
    scenes = [Scene(points, points[:12]) for points in (here, there)]
    axes: list[Any] = plot_scenes(scenes, "").axes
    first, second = (View(one._vertical_axis, one.azim).axes for one in axes)
    assert first[1].tolist() == [0.0, 1.0, 0.0]
    seen = [points @ rows.T for points, rows in ((here, first), (there, second))]
    seen = [points - points.mean(axis=0) for points in seen]
    np.testing.assert_allclose(seen[0], seen[1], atol=1e-9)
    # That is what matplotlib shows from there: rows of its camera are the same.
    axes[0].figure.canvas.draw()
    np.testing.assert_allclose(axes[0]._view_u, first[0], atol=1e-6)


def test_one_shape_is_drawn_in_its_colours(client: isomatch.Client, tmp_path: Path) -> None:
    mesh = blob_meshes()[0]
    colors = np.zeros((len(mesh.vertices), 3), dtype=np.uint8)
    colors[:, 1] = 200
    shape = client.upload((mesh.vertices, mesh.faces, colors))
    figure = client.geometry(shape).plot(tmp_path / "shape.png", title=shape.name)
    np.testing.assert_allclose(skin_colors(figure.axes[0]), [[0.0, 1.0, 0.0]] * 1280, atol=1e-6)
    assert (tmp_path / "shape.png").read_bytes().startswith(b"\x89PNG")
    # Titles are text, and no formulas.
    client.geometry(shape).plot(tmp_path / "again.png", title="a$x_{$.off")


def test_a_partial_matrix_is_drawn(tmp_path: Path) -> None:
    matrix = np.array([[0.0, 2.0, np.nan], [2.0, 0.0, 1.0], [np.nan, 1.0, 0.0]])
    partial = isomatch.PartialDissimilarities(
        job="j", state="running", shapes=("a" * 32, "b" * 32, "c" * 32), labels=None,
        pairs=3, pairs_done=2, matrix=matrix,
    )  # fmt: skip
    figure = partial.plot(tmp_path / "part.png")
    (image,) = figure.axes[0].images
    drawn = image.get_array()
    assert drawn is not None
    np.testing.assert_array_equal(np.ma.getmaskarray(drawn), np.isnan(matrix))
    assert "2 of 3 pairs" in figure.axes[0].get_title()


def test_a_matrix_is_drawn_in_the_order_of_its_labels(
    client: isomatch.Client, pair: Pair, tmp_path: Path
) -> None:
    mesh = blob_meshes()[0]
    long = client.upload((mesh.vertices * [1.0, 1.0, 2.0], mesh.faces))
    shapes, labels = [pair[0], long, pair[1]], ["round", "long", "round"]
    found = client.dissimilarities(shapes, labels, points=4, eigenpairs=30).result()
    figure = found.plot(path=tmp_path / "matrix.png")
    assert (tmp_path / "matrix.png").read_bytes().startswith(b"\x89PNG")
    axes = figure.axes[0]
    (image,) = axes.images
    drawn = image.get_array()
    assert drawn is not None
    np.testing.assert_array_equal(drawn, found.matrix[np.ix_([1, 0, 2], [1, 0, 2])])
    assert [text.get_text() for text in axes.get_xticklabels()] == ["long", "round", "round"]
    with pytest.raises(ValueError, match="only matches have alternatives"):
        found.plot(alternative=0)


def test_an_async_job_is_drawn(url: str, pair: Pair, tmp_path: Path) -> None:
    async def program() -> None:
        async with isomatch.AsyncClient(url) as client:
            job = await client.match(*pair, points=6, coarse_points=6)
            match = await job.result()
            figure = await job.plot(tmp_path / "match.svg")
            assert len(drawn_points(figure)[0][0]) == 6
            shown = match.plot()
            for one, same in zip(drawn_points(figure), drawn_points(shown), strict=True):
                np.testing.assert_array_equal(one[0], same[0])
        # What carries the requests of tasks carries none of those that block.
        transport = httpx2.AsyncHTTPTransport()
        async with isomatch.AsyncClient(url, transport=transport) as client:
            match = await (await client.job(job.id)).result()
            with pytest.raises(ValueError, match=r"job.plot\(\)"):
                match.plot()

    asyncio.run(program())
    assert b"<svg" in (tmp_path / "match.svg").read_bytes()


@pytest.mark.parametrize(("up", "lengths"), [("y", [1, 3, 2]), ("z", [2, 1, 3]), ("z", [1, 2, 3])])
def test_shapes_stand_and_are_seen_from_their_broad_side(up: str, lengths: list[float]) -> None:
    """A table: a plate on four legs."""
    corners = np.array([[x, y] for x in (-1.0, 1.0) for y in (-1.0, 1.0)])
    legs = np.column_stack([corners, np.zeros(4)])
    plate = np.column_stack([0.3 * corners, np.ones(4)])
    points = np.vstack([legs, plate])
    if up == "y":
        points = points[:, [1, 2, 0]]
    points = points * lengths
    faces = np.array([[leg, 4 + leg, 4 + (leg + 1) % 4] for leg in range(4)])
    axes: Any = plot_scenes([Scene(points, points[:1], faces)], "").axes[0]
    assert axes._vertical_axis == "xyz".index(up)
    axes.figure.canvas.draw()
    # The thinner of the two horizontal directions points to whoever looks.
    towards = np.abs(axes._view_w)
    level = [axis for axis in range(3) if axis != "xyz".index(up)]
    thin = min(level, key=lambda axis: np.ptp(points[:, axis]))
    assert np.argmax(towards) == thin


def test_near_points_have_like_colours() -> None:
    points = np.random.default_rng(7).normal(size=(50, 3)) * [1.0, 10.0, 0.0]
    colors = place_colors(points, points)
    assert colors.min() >= 0.0
    assert colors.max() <= 1.0
    other = points * 5.0 - 3.0
    np.testing.assert_allclose(colors, place_colors(other, other), atol=1e-12)
    np.testing.assert_allclose(colors[:7], place_colors(points[:7], points))
    assert place_colors(points[:0], points).shape == (0, 3)


def test_without_matplotlib_it_says_what_to_install(
    client: isomatch.Client, pair: Pair, monkeypatch: pytest.MonkeyPatch
) -> None:
    match = client.match(*pair, points=6, coarse_points=6).result()
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(isomatch.MissingExtra, match=r"pip install 'isomatch\[plot\]'") as missing:
        match.plot()
    assert isinstance(missing.value, ImportError)
