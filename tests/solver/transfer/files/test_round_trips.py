"""Attribute files: what is written is read again, here and by another program."""

import io
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from solver.errors import TransferError
from solver.mesh import read_mesh, triangle_mesh
from solver.transfer import Attribute
from solver.transfer.files import WrittenSurface, read_attributes
from tests.solver import shapes
from tests.solver.transfer.files.written import write_attributes

MESH = shapes.blob(1)
ROWS = MESH.n_vertices
SEEDS = st.integers(0, 2**31 - 1)
NAMES = np.array(["head", "left arm", "Fuß"])


def table(seed: int) -> dict[str, Attribute]:
    random = np.random.default_rng(seed)
    weights = random.random((ROWS, 6)) * (random.random((ROWS, 6)) < 0.5)
    weights[weights.sum(axis=1) == 0.0, 0] = 1.0
    columns = ("hip", "knee", "foot", "hand", "neck", "tail")
    return {
        "height": Attribute("height", random.standard_normal(ROWS)),
        "part": Attribute("part", random.integers(-3, 90, size=ROWS)),
        "name": Attribute("name", NAMES[random.integers(0, 3, size=ROWS)]),
        "flow": Attribute("flow", random.standard_normal((ROWS, 3)), ("x", "y", "z")),
        "colors": Attribute("colors", random.integers(0, 256, size=(ROWS, 3)) / 255.0),
        "weights": Attribute("weights", weights / weights.sum(axis=1, keepdims=True), columns),
    }


def returned(attributes: list[Attribute], file_type: str) -> dict[str, Attribute]:
    surface = WrittenSurface.of(MESH, attributes)
    data = write_attributes(attributes, file_type, surface)
    return {one.name: one for one in read_attributes(data, file_type)}


def close(found: Attribute, given: Attribute, tolerance: float) -> None:
    if given.values.dtype.kind in "iU":
        np.testing.assert_array_equal(found.values, given.values)
    else:
        np.testing.assert_allclose(found.values, given.values, atol=tolerance)


@given(SEEDS)
def test_archives_of_arrays_lose_nothing(seed: int) -> None:
    given_table = table(seed)
    found = returned(list(given_table.values()), "npz")
    for name, one in given_table.items():
        np.testing.assert_array_equal(found[name].values, one.values)
    assert found["weights"].columns == given_table["weights"].columns


@given(SEEDS)
def test_tables_lose_nothing_but_parts_of_bytes(seed: int) -> None:
    given_table = table(seed)
    found = returned(list(given_table.values()), "csv")
    for name, one in given_table.items():
        close(found[name], one, 1e-15)
    assert found["weights"].columns == given_table["weights"].columns
    assert found["flow"].columns == ("x", "y", "z")


@given(SEEDS)
def test_ply(seed: int) -> None:
    given_table = table(seed)
    found = returned(list(given_table.values()), "ply")
    codes = np.unique(given_table["name"].values, return_inverse=True)[1]
    np.testing.assert_array_equal(found["name"].values, codes)
    for name in ("height", "part", "flow", "colors", "weights"):
        close(found[name], given_table[name], 1e-15)


@given(SEEDS)
def test_glb_is_in_single_precision_and_keeps_four_joints(seed: int) -> None:
    given_table = table(seed)
    found = returned(list(given_table.values()), "glb")
    for name in ("height", "part", "flow"):
        close(found[name], given_table[name], 1e-6)
    np.testing.assert_allclose(found["colors"].values[:, :3], given_table["colors"].values)
    skin, weights = found["weights"], given_table["weights"].values
    assert skin.columns == given_table["weights"].columns
    np.testing.assert_allclose(skin.values.sum(axis=1), 1.0, atol=1e-6)
    assert ((skin.values > 0.0).sum(axis=1) <= 4).all()
    few = (weights > 0.0).sum(axis=1) <= 4
    np.testing.assert_allclose(skin.values[few], weights[few], atol=1e-6)


def test_obj_has_colours_or_groups_of_labels() -> None:
    given_table = table(0)
    found = returned([given_table["colors"]], "obj")
    np.testing.assert_allclose(found["colors"].values, given_table["colors"].values, atol=1e-6)
    labels = given_table["name"]
    text = write_attributes([labels], "obj", WrittenSurface.of(MESH, [labels])).decode()
    groups = [line for line in text.splitlines() if line.startswith("g ")]
    assert groups == ["g name_Fuß", "g name_head", "g name_left_arm"]
    assert read_mesh(text.encode(), "obj").n_faces == MESH.n_faces
    with pytest.raises(TransferError, match="OBJ cannot hold 'height'"):
        returned([given_table["height"]], "obj")


@pytest.mark.parametrize("file_type", ["ply", "obj", "glb"])
def test_surfaces_are_read_as_they_were(file_type: str) -> None:
    colors = table(1)["colors"]
    data = write_attributes([colors], file_type, WrittenSurface.of(MESH, [colors]))
    found = read_mesh(data, file_type)
    np.testing.assert_allclose(found.vertices, MESH.vertices, atol=1e-6)
    np.testing.assert_array_equal(found.faces, MESH.faces)
    assert found.colors is not None
    np.testing.assert_allclose(found.colors, colors.values, atol=1e-6)
    assert not found.warnings


@pytest.mark.parametrize("file_type", ["ply", "obj", "glb"])
def test_another_program_reads_the_files(file_type: str) -> None:
    given_table = table(2)
    attributes = [given_table["colors"]]
    if file_type != "obj":
        attributes += [given_table["height"], given_table["part"], given_table["weights"]]
    data = write_attributes(attributes, file_type, WrittenSurface.of(MESH, attributes))
    found: Any = trimesh.load(io.BytesIO(data), file_type=file_type, process=False, force="mesh")
    np.testing.assert_allclose(found.vertices, MESH.vertices, atol=1e-6)
    np.testing.assert_array_equal(found.faces, MESH.faces)
    octets = np.rint(255.0 * given_table["colors"].values)
    np.testing.assert_array_equal(found.visual.vertex_colors[:, :3], octets)
    if file_type == "ply":
        rows = found.metadata["_ply_raw"]["vertex"]["data"]
        np.testing.assert_array_equal(rows["part"].ravel(), given_table["part"].values)
    if file_type == "glb":
        np.testing.assert_allclose(
            found.vertex_attributes["_height"].ravel(), given_table["height"].values, atol=1e-6
        )


def test_rows_are_those_of_the_file_the_surface_was_read_from() -> None:
    """Vertex 0 is used by no face; the last is the same place as another, and is merged."""
    vertices = np.concatenate([np.full((1, 3), 50.0), MESH.vertices, MESH.vertices[:1]])
    faces = MESH.faces + 1
    faces[0][faces[0] == 1] = len(vertices) - 1
    mesh = triangle_mesh(vertices, faces)
    values = np.arange(float(len(vertices)))
    surface = WrittenSurface.of(mesh, [Attribute("number", values)])
    np.testing.assert_array_equal(surface.vertices[1:], vertices[1:])
    np.testing.assert_array_equal(surface.attributes[0].values, values)
    again = read_mesh(write_attributes([], "ply", surface), "ply")
    assert (again.n_vertices, again.n_faces) == (mesh.n_vertices, mesh.n_faces)


def test_missing_values_can_be_written(tmp_path: Any) -> None:
    short = [Attribute("a", np.array([1.0, np.nan])), Attribute("b", np.array([1, 2]))]
    surface = WrittenSurface.of(MESH, short)
    values: npt.NDArray[Any] = surface.attributes[0].values
    assert np.isnan(values[1:]).all()
    assert surface.attributes[1].values[2:].tolist() == [-1] * (ROWS - 2)
    for file_type in ("ply", "glb"):
        read_attributes(write_attributes(short, file_type, surface), file_type)


@pytest.mark.parametrize("text", ["vertex,a\n2,7\n0,5\n1,6\n", "a\n5\n6\n7\n", "a\r\n5\r\n6\r\n7"])
def test_a_column_of_vertex_numbers_orders_the_rows(text: str) -> None:
    (found,) = read_attributes(text.encode(), "csv")
    assert found.values.tolist() == [5, 6, 7]
