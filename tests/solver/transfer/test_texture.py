"""Textures carried along a map: sampled between vertices, and baked into an image."""

from collections.abc import Callable

import numpy as np
import pytest

from solver.arrays import FloatArray
from solver.mesh import TriangleMesh, read_mesh, textured_surface
from solver.registration import DenseCorrespondence
from solver.transfer import Landmarks, baked_texture, texture_colors
from solver.transfer.files import write_textured_glb
from tests.solver import shapes
from tests.solver.mesh.textures.textured_files import image_file, ramp, textured_glb, zipped_obj
from tests.solver.transfer.maps import FINE, MESH, registered

LOW, SIZE = MESH.vertices.min(axis=0)[:2], np.ptp(MESH.vertices, axis=0)[:2]
OTHER, WHERE = shapes.permuted(MESH, seed=5)


def uv(places: FloatArray) -> FloatArray:
    """Texture coordinates of a projection along z, within the image."""
    found: FloatArray = 0.1 + 0.8 * (places[:, :2] - LOW) / SIZE
    return found


def ramp_at(places: FloatArray) -> FloatArray:
    """Red and green of the ramp, (n, 2): linear in the texture coordinates."""
    found: FloatArray = (uv(places) * 256 - 0.5) / 255.0
    return found


FILES: dict[str, Callable[[], bytes]] = {
    "glb": lambda: textured_glb(MESH.vertices, MESH.faces, uv(MESH.vertices), image_file(ramp())),
    "zip": lambda: zipped_obj(
        MESH.vertices, MESH.faces, uv(MESH.vertices) * [1, -1] + [0, 1], image_file(ramp())
    ),
}


@pytest.fixture(scope="module")
def back() -> DenseCorrespondence:
    """The map from the permuted copy to the mesh."""
    inverse = registered(MESH, OTHER).inverse
    assert inverse is not None
    return inverse


@pytest.mark.parametrize("file_type", FILES)
def test_textures_are_sampled_between_vertices(file_type: str, back: DenseCorrespondence) -> None:
    read = textured_surface(FILES[file_type](), file_type)
    assert read is not None
    random = np.random.default_rng(0)
    corners = OTHER.faces[random.integers(0, OTHER.n_faces, size=200)]
    weights = random.dirichlet(np.ones(3), size=200)
    places = np.einsum("nc,ncd->nd", weights, OTHER.vertices[corners])
    found = texture_colors(Landmarks(corners, weights), back, *read)
    np.testing.assert_allclose(found[:, :2], ramp_at(places), atol=2e-3)


def test_a_baked_texture_shows_the_same_between_its_own_coordinates(
    back: DenseCorrespondence,
) -> None:
    read = textured_surface(FILES["glb"](), "glb")
    assert read is not None
    baked = baked_texture(OTHER, back, *read)
    random = np.random.default_rng(1)
    faces = random.integers(0, OTHER.n_faces, size=500)
    weights = random.dirichlet(np.full(3, 0.3), size=500)
    weights[:3] = np.eye(3)
    coordinates = np.einsum("nc,ncd->nd", weights, baked.coordinates[faces])
    places = np.einsum("nc,ncd->nd", weights, OTHER.vertices[OTHER.faces[faces]])
    found = baked.textures[0].sample(coordinates)
    np.testing.assert_allclose(found[:, :2], ramp_at(places), atol=6e-3)


def test_triangles_of_a_baked_texture_share_no_texel(back: DenseCorrespondence) -> None:
    """Of an odd number of triangles, too: their interpolated texels are their own."""
    read = textured_surface(FILES["glb"](), "glb")
    assert read is not None
    some = TriangleMesh(OTHER.vertices, OTHER.faces[:7], OTHER.vertex_ids)
    baked = baked_texture(some, back, *read)
    random = np.random.default_rng(2)
    weights = random.dirichlet(np.full(3, 0.3), size=300)
    size = baked.textures[0].size[0]
    owners: dict[tuple[int, int], int] = {}
    for face, coordinates in enumerate(baked.coordinates):
        texels = np.floor(weights @ coordinates * size - 0.5).astype(int)
        for x, y in {(x + i, y + j) for x, y in texels.tolist() for i in (0, 1) for j in (0, 1)}:
            if np.isclose((x + 0.5, y + 0.5), np.round(coordinates * size, 6)).all(axis=1).any():
                continue
            assert owners.setdefault((x, y), face) == face


@pytest.mark.parametrize("target", [OTHER, FINE], ids=["permuted", "finer"])
def test_a_baked_file_is_read_with_the_colours_of_the_source(target: TriangleMesh) -> None:
    """Up to the mipmaps of the reader, which mix neighbours in the image."""
    data = FILES["glb"]()
    read = textured_surface(data, "glb")
    inverse = registered(MESH, target).inverse
    assert read is not None
    assert inverse is not None
    baked = write_textured_glb("target", target, baked_texture(target, inverse, *read))
    found = read_mesh(baked, "glb")
    assert found.colors is not None
    assert (found.n_vertices, found.n_faces) == (target.n_vertices, target.n_faces)
    apart = np.abs(found.colors[:, :2] - ramp_at(found.vertices))
    assert apart.mean() < 0.05
    assert apart.max() < 0.2


def test_files_without_a_texture_have_none() -> None:
    plain = shapes.icosphere(0)
    text = ["OFF", f"{plain.n_vertices} {plain.n_faces} 0"]
    text += [" ".join(map(str, row)) for row in plain.vertices.tolist()]
    text += [" ".join(map(str, (3, *row))) for row in plain.faces.tolist()]
    assert textured_surface("\n".join(text).encode(), "off") is None


def test_textures_go_on_where_faces_repeat_vertices(back: DenseCorrespondence) -> None:
    """A file whose triangles have vertices of their own is one surface."""
    corners = MESH.faces.ravel()
    soup = MESH.vertices[corners]
    own = np.arange(len(corners)).reshape(-1, 3)
    data = zipped_obj(soup, own, uv(soup) * [1, -1] + [0, 1], image_file(ramp()))
    read = textured_surface(data, "zip")
    assert read is not None
    assert read[0].components == 1
    _, number = np.unique(corners, return_index=True)
    to_soup = DenseCorrespondence(
        back.source, number[back.target], number[back.faces], back.barycentric
    )
    random = np.random.default_rng(0)
    points = OTHER.faces[random.integers(0, OTHER.n_faces, size=200)]
    weights = random.dirichlet(np.ones(3), size=200)
    places = np.einsum("nc,ncd->nd", weights, OTHER.vertices[points])
    found = texture_colors(Landmarks(points, weights), to_soup, *read)
    np.testing.assert_allclose(found[:, :2], ramp_at(places), atol=2e-3)


def test_vertices_without_faces_and_without_a_place_are_left_out() -> None:
    vertices = np.vstack([MESH.vertices, np.full(3, np.nan)])
    image = image_file(ramp())
    read = textured_surface(zipped_obj(vertices, MESH.faces, vertices[:, :2] * 0, image), "zip")
    assert read is not None
    assert read[0].components == 1
    np.testing.assert_array_equal(read[0].vertex_ids, MESH.vertex_ids)
