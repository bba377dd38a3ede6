"""Figures of results of the running service, checked by the data they are made of."""

import asyncio
import struct
import sys
from pathlib import Path
from typing import Any

import isomatch
import numpy as np
import pytest
from isomatch._figures import surface_colors

from tests.client.shapes import blob_meshes

Pair = tuple[isomatch.Shape, isomatch.Shape]


def traces(figure: Any, kind: str, scene: str = "scene") -> list[Any]:
    """Traces of a kind in a subplot."""
    return [trace for trace in figure.data if trace.type == kind and trace.scene == scene]


def positions(trace: Any) -> np.ndarray:
    """Coordinates of a trace, (n, 3)."""
    return np.column_stack([trace.x, trace.y, trace.z])


def marked_points(figure: Any, *scenes: str) -> list[tuple[np.ndarray, tuple[str, ...]]]:
    """Positions and colours of the marked points of each scene, by default source and target."""
    found = []
    for scene in scenes or ("scene", "scene2"):
        (points,) = (one for one in traces(figure, "scatter3d", scene) if one.mode == "markers")
        found.append((positions(points), tuple(points.marker.color)))
    return found


def vertex_colors(figure: Any, scene: str) -> np.ndarray:
    """Vertex colours of a surface, (V, 3) between 0 and 1."""
    (surface,) = traces(figure, "mesh3d", scene)
    rows = [bytes.fromhex(color[1:]) for color in surface.vertexcolor]
    return np.array([list(row) for row in rows]) / 255.0


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
    (source, colors), (target, same) = marked_points(figure)
    first, second = blob_meshes()
    np.testing.assert_allclose(source, first.vertices[match.pairs[:, 0]], atol=1e-6)
    np.testing.assert_allclose(target, second.vertices[match.pairs[:, 1]], atol=1e-6)
    assert colors == same
    assert len(set(colors)) == 8
    for scene, mesh, numbers in zip(
        ("scene", "scene2"), (first, second), match.pairs.T, strict=True
    ):
        (surface,) = traces(figure, "mesh3d", scene)
        np.testing.assert_allclose(positions(surface), mesh.vertices, atol=1e-6)
        assert len(surface.i) == len(surface.j) == len(surface.k) == 1280
        assert surface.opacity < 1.0
        (points,) = traces(figure, "scatter3d", scene)
        assert points.text == tuple(map(str, numbers))
    assert [note.text for note in figure.layout.annotations] == ["source", "target"]
    assert f"energy {match.energy:.4g}" in figure.layout.title.text
    figure.write_html(tmp_path / "match.html", include_plotlyjs=False)
    assert "8 corresponding points" in (tmp_path / "match.html").read_text()

    match.save(tmp_path / "match.json")
    kept = isomatch.Match.from_json((tmp_path / "match.json").read_bytes())
    with pytest.raises(ValueError, match=rf"client.geometry\('{match.source}'\)"):
        kept.plot()
    again = kept.plot(*map(client.geometry, kept.drawn_ids()))
    np.testing.assert_array_equal(marked_points(again)[1][0], target)


def test_refined_points_are_drawn_where_they_are(client: isomatch.Client, pair: Pair) -> None:
    job = client.match(*pair, points=8, coarse_points=6, refine="gmds").wait()
    match = job.result()
    assert match.refinement is not None
    places = match.refinement.refined_positions(blob_meshes()[1].vertices)
    np.testing.assert_allclose(marked_points(job.plot())[1][0], places, atol=1e-6)


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
        np.testing.assert_allclose(marked_points(figure)[1][0], places, atol=1e-6)
        assert f"{answer.energy:.4g}" in figure.layout.title.text
    np.testing.assert_array_equal(
        marked_points(job.plot(alternative=1))[1][0],
        marked_points(match.plot(alternative=1))[1][0],
    )
    for wrong in (-1, count + 1):
        with pytest.raises(ValueError, match=f"it has {count}, numbered from 1"):
            match.plot(alternative=wrong)
    job.save_picture(tmp_path / "other.png", alternative=1)
    assert (tmp_path / "other.png").read_bytes() == job.picture(alternative=1) != job.picture()
    with pytest.raises(isomatch.InvalidRequest, match=f"it has {count}, numbered from 1"):
        job.picture(alternative=count + 1)


def test_a_dense_map_is_drawn(client: isomatch.Client, pair: Pair) -> None:
    match = client.match(*pair, points=8, coarse_points=6, dense=True, eigenpairs=30).result()
    assert match.dense is not None
    figure = match.plot()
    source, target = map(client.geometry, pair)
    # Each vertex has the colour of its target vertex.
    there = surface_colors(target.vertices)
    image = np.zeros(len(source.vertices), dtype=np.int64)
    image[source.rows(match.dense.source)] = target.rows(match.dense.target)
    step = 0.5 / 255.0 + 1e-9
    np.testing.assert_allclose(vertex_colors(figure, "scene"), there[image], atol=step)
    np.testing.assert_allclose(vertex_colors(figure, "scene2"), there, atol=step)
    (surface,) = traces(figure, "mesh3d")
    np.testing.assert_array_equal(np.column_stack([surface.i, surface.j, surface.k]), source.faces)
    assert len(np.unique(vertex_colors(figure, "scene"), axis=0)) > 300
    (_, colors), (_, same) = marked_points(figure)
    assert colors == same

    # Vertices without an image are gray, and an alternative's map is drawn with its pairs.
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
    np.testing.assert_allclose(marked_points(other)[0][0], places)
    left_out = ~np.isin(source.vertex_ids, half.source)
    assert left_out.sum() > 500
    np.testing.assert_allclose(vertex_colors(other, "scene")[left_out], 0.8, atol=step)


def test_one_shape_is_drawn_in_its_colours(client: isomatch.Client) -> None:
    mesh = blob_meshes()[0]
    colors = np.zeros((len(mesh.vertices), 3), dtype=np.uint8)
    colors[:, 1] = 200
    shape = client.upload((mesh.vertices, mesh.faces, colors))
    figure = client.geometry(shape).plot(title=shape.name)
    np.testing.assert_allclose(vertex_colors(figure, "scene") * 255.0, colors)
    assert figure.layout.title.text == shape.name


def test_a_cloud_is_drawn_as_points(client: isomatch.Client, pair: Pair) -> None:
    points = blob_meshes()[0].vertices
    shape = client.upload(points, name="cloud")
    cloud = client.geometry(shape)
    assert cloud.is_cloud
    assert not client.geometry(pair[0]).is_cloud
    assert repr(cloud) == "<Geometry of a cloud of 642 points>"
    figure = cloud.plot()
    assert not traces(figure, "mesh3d")
    (drawn,) = traces(figure, "scatter3d")
    np.testing.assert_allclose(positions(drawn), points, atol=1e-6)
    assert (drawn.mode, drawn.marker.size, drawn.marker.color) == ("markers", 2, "#9ca3af")

    match = client.match(shape, pair[1], points=6, coarse_points=6, dense=True).result()
    assert match.dense is not None
    figure = match.plot()
    assert not traces(figure, "mesh3d")
    assert len(traces(figure, "mesh3d", "scene2")) == 1
    sizes = [trace.marker.size for trace in traces(figure, "scatter3d")]
    assert sizes == [2, 6]
    cloud_colors = traces(figure, "scatter3d")[0].marker.color
    assert len(cloud_colors) == 642
    figure = client.match(pair[1], shape, points=6, coarse_points=6).result().plot()
    assert not traces(figure, "mesh3d", "scene2")


def test_a_geometry_can_be_uploaded_again(client: isomatch.Client) -> None:
    mesh = blob_meshes()[0]
    colors = np.arange(3 * 642).reshape(642, 3).astype(np.uint8)
    surface = client.upload((mesh.vertices, mesh.faces, colors))
    cloud = client.upload((mesh.vertices, None, colors))
    for shape, kind in ((surface, "mesh"), (cloud, "points")):
        again = client.upload(client.geometry(shape))
        assert (again.kind, again.has_colors) == (shape.kind, True) == (kind, True)
        found = client.geometry(again).colors
        assert found is not None
        np.testing.assert_array_equal(found, colors)


def test_shapes_are_seen_as_their_records_say(client: isomatch.Client, pair: Pair) -> None:
    job = client.match(*pair, points=8, coarse_points=6).wait()
    up, towards = np.array(pair[0].view)[1:]
    shown = client.geometry(pair[0]).plot(), client.geometry(pair[0].id).plot(), job.plot()
    for figure in shown:
        seen = figure.layout.scene.camera
        np.testing.assert_array_equal([seen.up[axis] for axis in "xyz"], up)
        np.testing.assert_allclose([seen.eye[axis] for axis in "xyz"], 1.3 * towards)


def test_a_partial_matrix_is_drawn() -> None:
    matrix = np.array([[0.0, 2.0, np.nan], [2.0, 0.0, 1.0], [np.nan, 1.0, 0.0]])
    partial = isomatch.PartialDissimilarities(
        job="j", state="running", shapes=("a" * 32, "b" * 32, "c" * 32), labels=None,
        pairs=3, pairs_done=2, matrix=matrix,
    )  # fmt: skip
    figure = partial.plot()
    (drawn,) = figure.data
    np.testing.assert_array_equal(drawn.customdata, matrix)
    np.testing.assert_array_equal(drawn.z, np.sqrt(matrix))
    assert (drawn.zmin, drawn.zmax) == (0.0, np.sqrt(2.0))  # all colours, of so few pairs
    assert drawn.hoverongaps is False
    assert "2 of 3 pairs" in figure.layout.title.text
    labels = ("feline", "canine", "canine")
    named = partial.model_copy(update={"names": ("cat", None, "dog"), "labels": labels}).plot()
    assert list(named.layout.xaxis.ticktext) == ["cat", "b" * 32, "dog"]


def test_a_matrix_is_drawn_by_class_in_the_order_of_first_shapes(
    client: isomatch.Client, pair: Pair
) -> None:
    mesh = blob_meshes()[0]
    long = client.upload((mesh.vertices * [1.0, 1.0, 2.0], mesh.faces), "long")
    shapes, labels = [pair[0], long, pair[1]], ["round", "long", "round"]
    found = client.dissimilarities(shapes, labels, points=4, eigenpairs=30).result()
    figure = found.plot()
    (drawn,) = figure.data
    ordered = found.matrix[np.ix_([0, 2, 1], [0, 2, 1])]
    np.testing.assert_array_equal(drawn.customdata, ordered)
    np.testing.assert_array_equal(drawn.z, np.sqrt(ordered))
    assert drawn.colorscale[0][1] == "#440154"  # Viridis
    # Names tell shapes of one class apart; lines are the borders of the classes.
    assert figure.layout.xaxis.ticktext == ("a.off", "b.obj", "long")
    assert drawn.hovertext[1][0].startswith("b.obj, a.off: ")
    assert [line.x0 for line in figure.layout.shapes if line.x0 == line.x1] == [1.5]
    assert figure.layout.yaxis.autorange == "reversed"
    with pytest.raises(ValueError, match="only matches have alternatives"):
        found.plot(alternative=0)


def test_an_async_job_is_drawn(url: str, pair: Pair) -> None:
    async def program() -> None:
        async with isomatch.AsyncClient(url) as client:
            job = await client.match(*pair, points=6, orientation=False)
            match = await job.result()
            figure = await job.plot()
            assert len(marked_points(figure)[0][0]) == 6
            # To request the shapes would block the event loop.
            with pytest.raises(ValueError, match=r"or use job\.plot\(\)"):
                match.plot()
            shown = match.plot(*[await client.geometry(one) for one in match.drawn_ids()])
            for one, same in zip(marked_points(figure), marked_points(shown), strict=True):
                np.testing.assert_array_equal(one[0], same[0])

    asyncio.run(program())


def test_without_plotly_the_error_names_the_extra(
    client: isomatch.Client, pair: Pair, monkeypatch: pytest.MonkeyPatch
) -> None:
    match = client.match(*pair, points=6, orientation=False).result()
    monkeypatch.setitem(sys.modules, "plotly", None)
    with pytest.raises(isomatch.MissingExtra, match=r"pip install 'isomatch\[plot\]'") as missing:
        match.plot()
    assert isinstance(missing.value, ImportError)
