"""Texture coordinates carried along a map: exact where they are continuous, whole at seams."""

import io
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
import trimesh

from solver.arrays import FloatArray, IntArray
from solver.errors import MeshError
from solver.mesh import TriangleMesh, mapped_surface, read_mesh, textured_surface, triangle_mesh
from solver.mesh.textures import Material, Paint, Texture, Wrap
from solver.registration import DenseCorrespondence
from solver.transfer import baked_texture, carried_paint
from solver.transfer.files import WrittenSurface, write_textured_glb, write_textured_obj
from tests.solver import shapes
from tests.solver.mesh.textures.textured_files import ramp, textured_obj, zipped
from tests.solver.transfer.maps import FINE, MESH, registered

OTHER, WHERE = shapes.permuted(MESH, seed=5)
TARGETS = pytest.mark.parametrize("target", [OTHER, FINE], ids=["permuted", "finer"])
IMAGE = Texture(ramp(), (Wrap.REPEAT, Wrap.CLAMP))


@cache
def back_to_mesh(target: TriangleMesh) -> DenseCorrespondence:
    """The map from a target to the mesh."""
    inverse = registered(MESH, target).inverse
    assert inverse is not None
    return inverse


def of_rows(dense: DenseCorrespondence, rows: slice) -> DenseCorrespondence:
    """A map of some vertices."""
    return DenseCorrespondence(
        dense.source[rows], dense.target[rows], dense.faces[rows], dense.barycentric[rows]
    )


def plane(places: FloatArray) -> FloatArray:
    """Texture coordinates without seams: a projection along z."""
    low, size = MESH.vertices.min(axis=0)[:2], np.ptp(MESH.vertices, axis=0)[:2]
    found: FloatArray = 0.1 + 0.8 * (places[..., :2] - low) / size
    return found


def turns(places: FloatArray) -> FloatArray:
    """Angle round the z axis, in turns."""
    found: FloatArray = np.arctan2(places[..., 1], places[..., 0]) / (2.0 * np.pi)
    return found


def round_the_axis(mesh: TriangleMesh) -> FloatArray:
    """(F, 3, 2) turns and heights, one chart that is cut at half a turn."""
    corners = mesh.vertices[mesh.faces]
    middle = turns(corners.mean(axis=1))[:, None]
    apart = turns(corners) - middle
    found: FloatArray = np.stack([middle + apart - np.rint(apart), corners[:, :, 2]], axis=2)
    return found


def two_charts(mesh: TriangleMesh) -> FloatArray:
    """(F, 3, 2) the upper faces left in the image, the lower ones right."""
    corners = mesh.vertices[mesh.faces]
    upper = corners[:, :, 2].mean(axis=1) > 0.0
    found: FloatArray = 0.4 * plane(corners)
    found[~upper, :, 0] += 0.6
    return found


def paint_of(coordinates: FloatArray, textures: tuple[Texture, ...] = (IMAGE,)) -> Paint:
    count = len(coordinates)
    return Paint(coordinates, np.zeros((count, 3)), np.zeros(count, dtype=np.int64), textures)


def extent(coordinates: FloatArray) -> FloatArray:
    """(F,) width of the triangles in the image."""
    found: FloatArray = np.ptp(coordinates[:, :, 0], axis=1)
    return found


def by_vertex(target: TriangleMesh, back: DenseCorrespondence, own: FloatArray) -> FloatArray:
    """(F, 3, 2) coordinates of each vertex by itself, with no regard to seams."""
    faces = {tuple(sorted(face)): number for number, face in enumerate(MESH.faces.tolist())}
    rows = [faces[tuple(sorted(corners))] for corners in back.faces.tolist()]
    order = np.argsort(MESH.faces[rows], axis=1)
    wanted = np.argsort(np.argsort(back.faces, axis=1), axis=1)
    places = np.take_along_axis(order, wanted, axis=1)
    corners = np.take_along_axis(own[rows], places[:, :, None], axis=1)
    of_vertex: FloatArray = np.einsum("nc,ncd->nd", back.barycentric, corners)
    return of_vertex[target.faces]


@TARGETS
def test_without_seams_each_vertex_has_one_place(target: TriangleMesh) -> None:
    found = carried_paint(
        target, back_to_mesh(target), MESH, paint_of(plane(MESH.vertices[MESH.faces]))
    )
    expected = plane(target.vertices[target.faces])
    np.testing.assert_allclose(found.coordinates, expected, atol=2e-2)
    places = np.column_stack([target.faces.ravel(), found.coordinates.reshape(-1, 2).round(9)])
    assert len(np.unique(places, axis=0)) == target.n_vertices
    assert found.textures == (IMAGE,)


def test_of_a_copy_they_are_the_same() -> None:
    found = carried_paint(OTHER, back_to_mesh(OTHER), MESH, paint_of(round_the_axis(MESH)))
    away = np.linalg.norm(OTHER.vertices[OTHER.faces][..., :2], axis=2).min(axis=1) > 0.1
    expected = round_the_axis(OTHER)
    np.testing.assert_allclose(found.coordinates[away], expected[away], atol=2e-3)


@TARGETS
def test_no_triangle_crosses_the_cut_of_a_chart(target: TriangleMesh) -> None:
    own, back = round_the_axis(MESH), back_to_mesh(target)
    found = carried_paint(target, back, MESH, paint_of(own)).coordinates
    away = np.linalg.norm(target.vertices[target.faces][..., :2], axis=2).min(axis=1) > 0.3
    assert extent(by_vertex(target, back, own))[away].max() > 0.8
    assert extent(found)[away].max() < 1.5 * extent(own)[away_from_axis(MESH)].max()
    apart = found - round_the_axis(target)
    apart[..., 0] -= np.rint(apart[..., 0])
    assert np.abs(apart[away]).max() < extent(own)[away_from_axis(MESH)].max()
    assert np.abs(apart[away]).mean() < 0.01


def away_from_axis(mesh: TriangleMesh) -> Any:
    return np.linalg.norm(mesh.vertices[mesh.faces][..., :2], axis=2).min(axis=1) > 0.3


@TARGETS
def test_each_triangle_is_in_one_chart(target: TriangleMesh) -> None:
    own, back = two_charts(MESH), back_to_mesh(target)
    found = carried_paint(target, back, MESH, paint_of(own)).coordinates[..., 0]
    left, right = (found < 0.5).all(axis=1), (found > 0.5).all(axis=1)
    assert (left | right).all()
    assert not (left & right).any()
    upper = target.vertices[target.faces][..., 2].mean(axis=1) > 0.0
    assert (left == upper).mean() > 0.97
    naive = by_vertex(target, back, own)[..., 0]
    assert not ((naive < 0.5).all(axis=1) | (naive > 0.5).all(axis=1)).all()


def test_triangles_over_a_gap_stay_in_the_chart_of_their_centre() -> None:
    """Components of the source are matched as one surface, but in the image they lie apart."""
    target = shapes.plane_grid(20, 11, 1.0)
    right = target.vertices[:, 0] > 0.5
    whole = (right[target.faces] == right[target.faces[:, :1]]).all(axis=1)
    # A gap of two fifths of a cell.
    places = target.vertices - np.outer(right, [0.03, 0.0, 0.0])
    source = triangle_mesh(places, target.faces[whole])
    faces, shares = source.at_vertices(np.arange(source.n_vertices))
    every = source.vertex_ids
    back = DenseCorrespondence(every, every, source.vertex_ids[source.faces[faces]], shares)
    own = 0.3 * places[:, :2] + np.outer(right, [0.7, 0.0])
    found = carried_paint(target, back, source, paint_of(own[source.faces])).coordinates
    assert source.components == 2
    assert extent(own[target.faces]).max() > 0.7
    assert extent(found).max() < 1.01 * extent(own[source.faces]).max()
    np.testing.assert_allclose(found[whole], own[target.faces[whole]], atol=1e-9)


def test_there_and_back_loses_little() -> None:
    there = registered(MESH, FINE)
    assert there.inverse is not None
    own = paint_of(round_the_axis(MESH))
    forth = carried_paint(FINE, there.inverse, MESH, own)
    back = carried_paint(MESH, there, FINE, forth).coordinates
    apart = back - own.coordinates
    apart[..., 0] -= np.rint(apart[..., 0])
    assert np.abs(apart[away_from_axis(MESH)]).mean() < 5e-3
    assert extent(back)[away_from_axis(MESH)].max() < 0.5


def test_faces_without_texture_or_map_have_none() -> None:
    own = paint_of(plane(MESH.vertices[MESH.faces]))
    upper: IntArray = np.where(MESH.vertices[MESH.faces][..., 2].mean(axis=1) > 0.0, 0, -1)
    colored = replace(own, texture_of_face=upper, colors=np.full((MESH.n_faces, 3), 0.25))
    back = back_to_mesh(OTHER)
    some = DenseCorrespondence(
        back.source[5:], back.target[5:], back.faces[5:], back.barycentric[5:]
    )
    found = carried_paint(OTHER, some, MESH, colored)
    mapped = (OTHER.faces >= 5).all(axis=1)
    assert (found.texture_of_face[~mapped] == -1).all()
    assert (found.colors[~mapped] == 0.0).all()
    assert (found.colors[mapped] == 0.25).all()
    low = OTHER.vertices[OTHER.faces][..., 2].mean(axis=1) < -0.1
    high = OTHER.vertices[OTHER.faces][..., 2].mean(axis=1) > 0.1
    assert (found.texture_of_face[mapped & low] == -1).all()
    assert (found.texture_of_face[mapped & high] == 0).all()


def test_of_an_empty_map_nothing_is_textured() -> None:
    back = back_to_mesh(OTHER)
    none = of_rows(back, slice(2))
    found = carried_paint(OTHER, none, MESH, paint_of(plane(MESH.vertices[MESH.faces])))
    assert (found.texture_of_face == -1).all()
    data = write_textured_obj(WrittenSurface.of(OTHER, [], "b"), found)
    assert b"vt" not in data
    assert mapped_surface(data, "obj") is None
    assert read_mesh(write_textured_glb("b", OTHER, found), "glb").n_faces == OTHER.n_faces


@TARGETS
def test_glb_shows_the_image_of_the_source(target: TriangleMesh) -> None:
    paint = paint_of(plane(MESH.vertices[MESH.faces]))
    carried = carried_paint(target, back_to_mesh(target), MESH, paint)
    data = write_textured_glb("target", target, carried, mipmaps=True)
    read = textured_surface(data, "glb")
    assert read is not None
    surface, again = read
    assert surface.n_vertices == target.n_vertices
    np.testing.assert_array_equal(again.textures[0].pixels, IMAGE.pixels)
    assert again.textures[0].wrap == IMAGE.wrap
    np.testing.assert_allclose(again.coordinates, carried.coordinates, atol=1e-6)
    seen: Any = trimesh.load(io.BytesIO(data), file_type="glb", process=False, force="mesh")
    assert len(seen.vertices) == target.n_vertices
    assert seen.visual.material.baseColorTexture.size == IMAGE.size
    # v upwards, as trimesh has it.
    expected = plane(seen.vertices) * [1.0, -1.0] + [0.0, 1.0]
    np.testing.assert_allclose(seen.visual.uv, expected, atol=2e-2)


def test_glb_has_a_material_for_each_texture_and_colour() -> None:
    """Two textures, one darkened, and faces without."""
    third = np.arange(MESH.n_faces) % 3
    own = paint_of(two_charts(MESH), (IMAGE, Texture(255 - ramp())))
    light = np.where(third[:, None] == 1, 0.25, 1.0) * np.ones(3)
    paint = replace(
        own, texture_of_face=third - 1, light=light, colors=np.full((MESH.n_faces, 3), 0.5)
    )
    read = textured_surface(write_textured_glb("mesh", MESH, paint), "glb")
    assert read is not None
    surface, again = read
    assert surface.n_faces == MESH.n_faces
    number = np.argsort(third - 1, kind="stable")
    assert again.light is not None
    np.testing.assert_allclose(again.light[third[number] > 0], light[number][third[number] > 0])
    np.testing.assert_allclose(again.colors[third[number] == 0], 0.5, atol=1e-6)
    sums = [again.textures[i].pixels.astype(int).sum() for i in again.texture_of_face[[-1, 700]]]
    assert sorted(sums) == sorted(int(one.pixels.astype(int).sum()) for one in own.textures)


def test_materials_keep_their_names_metalness_and_roughness() -> None:
    materials = (Material("skin", 0.0, 0.4), Material("gold", 1.0, 0.2), Material("", 0.5))
    ours, theirs = (
        np.searchsorted([-0.3, 0.3], mesh.vertices[mesh.faces][:, :, 2].mean(axis=1))
        for mesh in (MESH, OTHER)
    )
    paint = replace(paint_of(two_charts(MESH)), material_of_face=ours, materials=materials)
    carried = carried_paint(OTHER, back_to_mesh(OTHER), MESH, paint)
    baked = baked_texture(OTHER, back_to_mesh(OTHER), MESH, paint)
    for found in (carried, baked):
        assert found.materials == materials
        np.testing.assert_array_equal(found.material_of_face, theirs)
        data = write_textured_glb("other", OTHER, found)
        read = textured_surface(data, "glb")
        assert read is not None
        # The file has the triangles material by material, and one image.
        assert read[1].material_of_face is not None
        again = [read[1].materials[place] for place in read[1].material_of_face.tolist()]
        assert again == [materials[place] for place in sorted(theirs)]
        assert len(read[1].textures) == 1
    few = carried_paint(OTHER, of_rows(back_to_mesh(OTHER), np.s_[:100]), MESH, paint)
    assert few.material_of_face is not None
    assert few.material_of_face.min() == -1
    with pytest.raises(MeshError, match="a factor of a material of the glTF file is not finite"):
        textured_surface(data.replace(b'"roughnessFactor":0.4', b'"roughnessFactor":NaN'), "glb")


def test_factors_that_are_not_given_are_those_of_the_format() -> None:
    """Of an image of factors, which is not read, nothing is known."""
    data = write_textured_glb("mesh", MESH, paint_of(two_charts(MESH)))
    factors = b'"metallicFactor":0.0,"roughnessFactor":1.0'
    for written, expected in (
        (b'"name":"a"', Material("", 1.0, 1.0)),
        (b'"metallicRoughnessTexture":{"index":0}', Material("", 0.0, 1.0)),
    ):
        read = textured_surface(data.replace(factors, written.ljust(len(factors))), "glb")
        assert read is not None
        assert read[1].materials == (expected,)


def test_obj_is_read_with_the_same_coordinates() -> None:
    carried = carried_paint(OTHER, back_to_mesh(OTHER), MESH, paint_of(two_charts(MESH)))
    data = write_textured_obj(WrittenSurface.of(OTHER, [], "b"), carried)
    read = mapped_surface(data, "obj")
    assert read is not None
    surface, again = read
    np.testing.assert_array_equal(surface.vertices, OTHER.vertices)
    np.testing.assert_array_equal(surface.faces, OTHER.faces)
    np.testing.assert_allclose(again.coordinates, carried.coordinates, atol=1e-15)
    seen: Any = trimesh.load(io.BytesIO(data), file_type="obj", process=False, force="mesh")
    found = seen.visual.uv[seen.faces] * [1.0, -1.0] + [0.0, 1.0]
    np.testing.assert_allclose(found, carried.coordinates, atol=1e-8)
    assert read_mesh(data, "obj").n_faces == OTHER.n_faces


def test_an_obj_file_has_coordinates_without_its_image() -> None:
    coordinates = plane(MESH.vertices) * [1, -1] + [0, 1]
    data = textured_obj(MESH.vertices, MESH.faces, coordinates)
    read = mapped_surface(data, "obj")
    assert read is not None
    carried = carried_paint(OTHER, back_to_mesh(OTHER), *read)
    np.testing.assert_allclose(carried.coordinates, plane(OTHER.vertices[OTHER.faces]), atol=2e-3)
    assert textured_surface(data, "obj") is None
    glb = write_textured_glb("b", OTHER, carried)
    assert read_mesh(glb, "glb").n_vertices == OTHER.n_vertices


def test_coordinates_go_on_where_faces_repeat_vertices() -> None:
    """A file whose triangles have vertices of their own has no seam between them."""
    corners = MESH.faces.ravel()
    soup = MESH.vertices[corners]
    own = np.arange(len(corners)).reshape(-1, 3)
    read = mapped_surface(textured_obj(soup, own, plane(soup) * [1, -1] + [0, 1]), "obj")
    assert read is not None
    back = back_to_mesh(OTHER)
    _, number = np.unique(corners, return_index=True)
    to_soup = DenseCorrespondence(
        back.source, number[back.target], number[back.faces], back.barycentric
    )
    carried = carried_paint(OTHER, to_soup, *read)
    np.testing.assert_allclose(carried.coordinates, plane(OTHER.vertices[OTHER.faces]), atol=2e-3)


def test_a_zip_without_images_has_the_coordinates_of_its_obj_file() -> None:
    data = textured_obj(MESH.vertices, MESH.faces, plane(MESH.vertices) * [1, -1] + [0, 1])
    bare = data.replace(b"mtllib skin.mtl\n", b"")
    for files in ({"a.obj": bare}, {"a.obj": data, "skin.mtl": b"newmtl skin\nKd 1 0 0\n"}):
        read = mapped_surface(zipped(files), "zip")
        assert read is not None
        expected = mapped_surface(data, "obj")
        assert expected is not None
        np.testing.assert_array_equal(read[1].coordinates, expected[1].coordinates)
        assert textured_surface(zipped(files), "zip") is None


def test_files_without_coordinates_have_none() -> None:
    triangle = b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
    assert mapped_surface(zipped({"a.off": triangle}), "zip") is None
    plain = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    assert mapped_surface(plain, "obj") is None
    assert mapped_surface(b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "off") is None
