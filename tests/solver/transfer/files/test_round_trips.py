"""Attribute files: what is written is read again, here and by another program."""

import io
import json
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from solver.errors import TransferError
from solver.mesh import read_mesh, triangle_mesh, vertex_normals
from solver.mesh.formats import read_glb_with
from solver.mesh.textures import Paint
from solver.transfer import FACES, VERTICES, Attribute
from solver.transfer.files import WrittenSurface, read_attributes, write_npz, write_textured_glb
from solver.transfer.files.limits import MOST_COLUMNS
from tests.solver import shapes
from tests.solver.mesh import mesh_files
from tests.solver.transfer.files.written import write_attributes

MESH = shapes.blob(1)
ROWS = MESH.n_vertices
SEEDS = st.integers(0, 2**31 - 1)
TRIANGLE = triangle_mesh(np.eye(3), np.array([[0, 1, 2]]))
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
    np.testing.assert_array_equal(found["name"].values, given_table["name"].values)
    for name in ("height", "part", "flow", "colors", "weights"):
        close(found[name], given_table[name], 1e-15)


@given(SEEDS)
def test_glb_is_in_single_precision_and_keeps_all_joints(seed: int) -> None:
    given_table = table(seed)
    found = returned(list(given_table.values()), "glb")
    for name in ("height", "part", "flow"):
        close(found[name], given_table[name], 1e-6)
    np.testing.assert_allclose(found["colors"].values[:, :3], given_table["colors"].values)
    skin, weights = found["weights"], given_table["weights"].values
    assert skin.columns == given_table["weights"].columns
    np.testing.assert_allclose(skin.values, weights, atol=1e-6)


@pytest.mark.parametrize(("joints", "sets"), [(3, 1), (4, 1), (5, 2), (13, 4)])
def test_glb_has_joints_in_sets_of_four_the_greatest_first(joints: int, sets: int) -> None:
    weights = np.random.default_rng(joints).dirichlet(np.ones(joints), size=ROWS)
    skin = Attribute("weights", weights, tuple(f"j{number}" for number in range(joints)))
    data = write_attributes([skin], "glb", WrittenSurface.of(MESH, [skin]))
    (found,) = read_attributes(data, "glb")
    np.testing.assert_allclose(found.values, weights, atol=1e-6)
    primitive = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])["meshes"][0]
    attributes = primitive["primitives"][0]["attributes"]
    assert sum(name.startswith("JOINTS_") for name in attributes) == sets
    first = read_glb_with(data, lambda file: file.normalised(attributes["WEIGHTS_0"]))
    np.testing.assert_allclose(first[:, 0], weights.max(axis=1), atol=1e-6)
    opened: Any = trimesh.load(io.BytesIO(data), file_type="glb", force="mesh", process=False)
    assert len(opened.vertices) == ROWS


@pytest.mark.parametrize("what", ["plain", "joints", "textured"])
@pytest.mark.parametrize(
    ("scale", "place"),
    [(1.0, [5e6, 5e5, 100.0]), (1e50, [0.0, 0, 0]), (1e-50, [0.0, 0, 0]), (1e35, [3e37, 0, 0])],
)
def test_glb_keeps_shapes_far_from_the_origin_and_of_any_size(
    scale: float, place: list[float], what: str
) -> None:
    mesh = triangle_mesh(scale * MESH.vertices + place, MESH.faces)
    attributes = [table(0)["weights"]] if what == "joints" else []
    if what == "textured":
        data = write_textured_glb("mesh", mesh, plain_paint(mesh.n_faces))
    else:
        data = write_attributes(attributes, "glb", WrittenSurface.of(mesh, attributes))
    found = read_mesh(data, "glb")
    np.testing.assert_array_equal(found.faces, mesh.faces)
    np.testing.assert_allclose(found.vertices, mesh.vertices, rtol=1e-15, atol=1e-6 * scale)
    if what != "joints":  # trimesh does not know of skins
        seen: Any = trimesh.load(io.BytesIO(data), file_type="glb", process=False)
        (corners,) = seen.dump()
        np.testing.assert_allclose(
            corners.bounds,
            [mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)],
            rtol=1e-15,
            atol=1e-6 * scale,
        )


def test_glb_of_shapes_near_the_origin_has_nodes_without_a_transformation() -> None:
    near = triangle_mesh(MESH.vertices + 7.0, MESH.faces)
    for data in (
        write_attributes([], "glb", WrittenSurface.of(near, [])),
        write_textured_glb("mesh", near, plain_paint(near.n_faces)),
    ):
        (node,) = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])["nodes"]
        assert not {"translation", "scale", "matrix"} & {*node}


def plain_paint(count: int) -> Paint:
    """White faces."""
    return Paint(np.zeros((count, 3, 2)), np.ones((count, 3)), np.full(count, -1), ())


@pytest.mark.parametrize("file_type", ["npz", "csv", "ply", "glb"])
@pytest.mark.parametrize("what", ["joints", "numbers", "numbers and a joint"])
def test_as_many_columns_as_are_read_can_be_read_again(file_type: str, what: str) -> None:
    """Besides colours, and what a format has itself."""
    random = np.random.default_rng(0)
    joints = {"joints": MOST_COLUMNS, "numbers": 0, "numbers and a joint": 1}[what]
    given_table = [Attribute("colors", random.integers(0, 256, (3, 4)) / 255.0)]
    if joints:
        names = tuple(f"joint {number:080}" for number in range(joints))
        weights = random.dirichlet(np.ones(joints), size=3)
        parents = (-1,) * joints
        given_table.append(Attribute("weights", weights, names, parents=parents))
    given_table += [
        Attribute(f"n{place}", random.random(3)) for place in range(MOST_COLUMNS - joints)
    ]
    data = write_attributes(given_table, file_type, WrittenSurface.of(TRIANGLE, given_table))
    found = {one.name: one for one in read_attributes(data, file_type)}
    for one in given_table:
        np.testing.assert_allclose(found[one.name].values, one.values, atol=1e-6)


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
    read_attributes(write_attributes(short, "ply", surface), "ply")
    with pytest.raises(TransferError, match="'a', which has vertices without a value; choose PLY"):
        write_attributes(short, "glb", surface)


def test_glb_has_zeros_at_vertices_of_no_face() -> None:
    vertices = np.concatenate([MESH.vertices, np.full((1, 3), 50.0)])
    heights = np.append(np.linspace(1.0, 2.0, ROWS), np.nan)
    one = Attribute("height", heights)
    surface = WrittenSurface.of(triangle_mesh(vertices, MESH.faces), [one])
    found = read_attributes(write_attributes([one], "glb", surface), "glb")[0]
    np.testing.assert_allclose(found.values, np.nan_to_num(heights), atol=1e-6)


@pytest.mark.parametrize(
    ("file_type", "values", "refused"),
    [
        ("glb", [2**24 + 1, 2**24, 0], "beyond 16777216"),
        ("glb", [-(2**24) - 1, 2, 0], "beyond 16777216"),
        ("glb", [1e39, 2.0, 0.0], "beyond 3.4028235e\\+38"),
        ("ply", [2**53 + 1, 2**53, 0], "beyond 2\\^53"),
        ("ply", [-(2**63), 2, 0], "beyond 2\\^53"),
    ],
)
def test_numbers_that_would_change_are_refused(
    file_type: str, values: list[float], refused: str
) -> None:
    one = Attribute("part", np.array(values))
    surface = WrittenSurface.of(TRIANGLE, [one])
    message = f"cannot hold 'part', which has numbers {refused}; choose CSV or NPZ"
    with pytest.raises(TransferError, match=message):
        write_attributes([one], file_type, surface)
    kept = {
        one.name: one for one in read_attributes(write_attributes([one], "csv", surface), "csv")
    }
    np.testing.assert_array_equal(kept["part"].values, values)


@pytest.mark.parametrize(("file_type", "greatest"), [("glb", 2**24), ("ply", 2**53)])
def test_the_greatest_labels_are_kept(file_type: str, greatest: int) -> None:
    one = Attribute("part", np.array([greatest, -greatest, greatest - 1]))
    data = write_attributes([one], file_type, WrittenSurface.of(TRIANGLE, [one]))
    np.testing.assert_array_equal(read_attributes(data, file_type)[0].values, one.values)


@pytest.mark.parametrize("file_type", ["npz", "csv"])
def test_missing_values_are_read_again(file_type: str) -> None:
    gaps = [
        Attribute("height", np.array([1.5, np.nan, -2.0])),
        Attribute("flow", np.array([[1.0, 2.0], [np.nan, np.nan], [0.5, 0.5]]), ("u", "v")),
        Attribute("name", np.array(["", "head", "tail"])),
        Attribute("part", np.array([4, -1, 2])),
    ]
    data = write_attributes(gaps, file_type, WrittenSurface.of(TRIANGLE, gaps))
    found = {one.name: one for one in read_attributes(data, file_type)}
    for one in gaps:
        np.testing.assert_array_equal(found[one.name].values, one.values)


@pytest.mark.parametrize("file_type", ["csv", "ply"])
def test_attributes_called_as_what_a_file_has_itself(file_type: str) -> None:
    called = ("x", "x_", "nz", "vertex", "face", "count", "corners", "vertex_indices")
    given_table = [Attribute(name, np.arange(3) + row) for row, name in enumerate(called)]
    data = write_attributes(given_table, file_type, WrittenSurface.of(TRIANGLE, given_table))
    found = read_attributes(data, file_type)
    assert [one.values.tolist() for one in found] == [one.values.tolist() for one in given_table]
    own = {"csv": ("vertex", "face"), "ply": ("x", "nz", "count", "vertex_indices")}[file_type]
    for one, name in zip(found, called, strict=True):
        assert one.name.rstrip("_") == name.rstrip("_")
        assert (one.name != name) == (name in own)


@pytest.mark.parametrize("called", [("file", "allow_pickle", "joint_names"), ("weights", "joints")])
def test_archives_have_attributes_of_any_name(called: tuple[str, ...]) -> None:
    given_table = [Attribute(name, np.arange(3) + row) for row, name in enumerate(called)]
    found = read_attributes(write_npz(given_table), "npz")
    assert [one.values.tolist() for one in found] == [one.values.tolist() for one in given_table]
    own = {"joint_names": "joint_names_", "joints": "joints_"}
    assert [one.name for one in found] == [own.get(name, name) for name in called]


def test_joints_alone_keep_their_name() -> None:
    (found,) = read_attributes(write_npz([Attribute("joints", np.arange(3))]), "npz")
    assert found.name == "joints"


def test_properties_of_ply_differ_where_names_are_alike_in_ascii() -> None:
    called = ("ä", "ö", "?", "left arm", "left_arm")
    given_table = [Attribute(name, np.arange(3) + row) for row, name in enumerate(called)]
    data = write_attributes(given_table, "ply", WrittenSurface.of(TRIANGLE, given_table))
    found = read_attributes(data, "ply")
    assert [one.values.tolist() for one in found] == [one.values.tolist() for one in given_table]
    assert len({one.name for one in found}) == len(called)


def ply_of_labels(*attributes: Attribute) -> bytes:
    return write_attributes([], "ply", WrittenSurface.of(TRIANGLE, attributes))


@pytest.mark.parametrize(
    "texts",
    [
        ["Ä", "Ö", "Ä"],
        ["", "left  arm ", " left arm"],
        ["end_header", "7 label", "property x"],
    ],
)
def test_labels_of_ply_are_read_as_text(texts: list[str]) -> None:
    on_faces = Attribute("größe", np.array([texts[1]]), on=FACES)
    data = ply_of_labels(Attribute("größe", np.array(texts)), on_faces)
    (found,) = read_attributes(data, "ply")
    assert (found.on, found.values.tolist()) == (VERTICES, texts)
    assert read_mesh(data, "ply").n_faces == 1
    legend = f"comment label gr??e 0 {min(texts)}\n"
    assert legend.encode() in data


def test_line_breaks_of_labels_become_blanks_in_ply() -> None:
    (found,) = read_attributes(ply_of_labels(Attribute("a", np.array(["b\nc", "d", "e"]))), "ply")
    assert found.values.tolist() == ["b c", "d", "e"]


def test_legends_of_ply_fit_into_the_header() -> None:
    """Of many labels the numbers alone are written."""
    vertices = np.random.default_rng(0).random((30_000, 3))
    faces = np.arange(30_000).reshape(-1, 3)
    many = Attribute("many", np.array([f"Müller {row} {'x' * 40}" for row in range(30_000)]))
    few = Attribute("few", np.where(np.arange(30_000) % 2, "odd", "even"))
    surface = WrittenSurface("s", vertices, faces, (many, few))
    data = write_attributes([], "ply", surface)
    found = {one.name: one.values for one in read_attributes(data, "ply")}
    assert found["many"].dtype.kind == "i"
    assert len(set(found["many"].tolist())) == 30_000
    np.testing.assert_array_equal(found["few"], few.values)
    assert b"comment the 30000 labels of many are too long for this header\n" in data


@pytest.mark.parametrize(
    "comment", ["label a 0 b", "label a", "label", "label b 5 b", "label a x y"]
)
def test_legends_that_do_not_name_all_numbers_change_none(comment: str) -> None:
    lines = ["ply", "format ascii 1.0", f"comment {comment}", "element vertex 2"]
    lines += ["property float x", "property int a", "end_header", "0 0", "0 5", ""]
    (found,) = read_attributes("\n".join(lines).encode(), "ply")
    assert found.values.tolist() == [0, 5]


def test_ply_has_colours_with_opacity() -> None:
    colors = np.array([[1.0, 0.0, 0.2, 0.4], [0.0, 1.0, 0.0, 1.0], [0.0, 0.0, 1.0, 0.0]])
    for on in (VERTICES, FACES):
        table = colors if on == VERTICES else colors[:1]
        one = Attribute("colors", table, on=on)
        surface = WrittenSurface.of(triangle_mesh(np.eye(3), np.array([[0, 1, 2]])), [one])
        (found,) = read_attributes(write_attributes([], "ply", surface), "ply")
        assert (found.on, found.columns) == (on, ("red", "green", "blue", "alpha"))
        np.testing.assert_allclose(found.values, table)


@pytest.mark.parametrize(
    ("properties", "row", "expected"),
    [
        ("float red", "0.5", {"red": 0.5}),
        ("uchar red;uchar alpha", "5 6", {"red": 5, "alpha": 6}),
        ("float red;float green;float blue", "-1 0 1", {"red": -1, "green": 0, "blue": 1}),
        ("uchar red;uchar green;uchar blue;float alpha", "255 0 0 0.5", {"colors": [1, 0, 0, 0.5]}),
        (
            "uchar red;uchar green;uchar blue;float alpha",
            "255 0 0 -2",
            {"colors": [1, 0, 0], "alpha": -2},
        ),
        (
            "int colors;uchar red;uchar green;uchar blue",
            "7 255 0 0",
            {"colors_": 7, "colors": [1, 0, 0]},
        ),
    ],
)
def test_no_property_of_ply_is_dropped(properties: str, row: str, expected: dict[str, Any]) -> None:
    lines = ["ply", "format ascii 1.0", "element vertex 1"]
    lines += [f"property {one}" for one in ("float x", *properties.split(";"))]
    data = "\n".join([*lines, "end_header", f"0 {row}", ""]).encode()
    found = {one.name: one.values[0].tolist() for one in read_attributes(data, "ply")}
    assert found == expected


@pytest.mark.parametrize("text", ["vertex,a\n2,7\n0,5\n1,6\n", "a\n5\n6\n7\n", "a\r\n5\r\n6\r\n7"])
def test_a_column_of_vertex_numbers_orders_the_rows(text: str) -> None:
    (found,) = read_attributes(text.encode(), "csv")
    assert found.values.tolist() == [5, 6, 7]


def test_the_case_of_reserved_names_does_not_count() -> None:
    text = b"VERTEX,Red,GREEN,blue,Weights.Left,weights.Right,Part,Green_\n" + b"".join(
        b"%d,%d,0,255,0.5,0.5,7,1\n" % (row, row) for row in (1, 0)
    )
    found = {one.name: one for one in read_attributes(text, "csv")}
    assert [*found] == ["colors", "weights", "Part", "Green_"]
    assert {one.on for one in found.values()} == {VERTICES}
    np.testing.assert_allclose(255.0 * found["colors"].values, [[0, 0, 255], [1, 0, 255]])
    assert found["weights"].columns == ("Left", "Right")
    (alone,) = read_attributes(b"Red\n1\n2\n", "csv")
    assert alone.name == "Red"


def test_a_column_called_as_the_numbers_in_another_case_is_written_under_another_name() -> None:
    one = Attribute("Vertex", np.array([5, 6, 7]))
    data = write_attributes([one], "csv", WrittenSurface.of(TRIANGLE, [one]))
    (found,) = read_attributes(data, "csv")
    assert (found.name, found.values.tolist()) == ("Vertex_", [5, 6, 7])


@pytest.mark.parametrize("none", ["", "nan", "NaN", "NA", "N/A", "null", "NULL", " "])
def test_cells_without_a_value(none: str) -> None:
    text = f"a,b,name\n{none},1,head\n2.5,{none},{none}\n3,3,NA\n"
    found = {one.name: one.values for one in read_attributes(text.encode(), "csv")}
    np.testing.assert_array_equal(found["a"], [np.nan, 2.5, 3.0])
    np.testing.assert_array_equal(found["b"], [1.0, np.nan, 3.0])
    assert found["name"].tolist() == ["head", none, "NA"]  # of text, these are labels


# --- values of faces ------------------------------------------------------------------------------


def of_faces(seed: int) -> dict[str, Attribute]:
    random, count = np.random.default_rng(seed), MESH.n_faces
    return {
        "heat": Attribute("heat", random.standard_normal(count), on=FACES),
        "segment": Attribute("segment", random.integers(0, 9, size=count), on=FACES),
        "flow": Attribute("flow", random.standard_normal((count, 3)), ("x", "y", "z"), FACES),
        "colors": Attribute("colors", random.integers(0, 256, size=(count, 3)) / 255.0, on=FACES),
    }


def surface_with(*attributes: Attribute) -> WrittenSurface:
    mesh = triangle_mesh(MESH.vertices, MESH.faces)
    return WrittenSurface.of(mesh, attributes)


@given(SEEDS)
def test_tables_and_ply_say_that_values_are_of_faces(seed: int) -> None:
    """PLY holds those of vertices beside them."""
    faces, height = of_faces(seed), table(seed)["height"]
    surface = surface_with(*faces.values(), height)
    for file_type, given_table in (("csv", faces), ("ply", faces | {"height": height})):
        data = write_attributes(list(given_table.values()), file_type, surface)
        found = {one.name: one for one in read_attributes(data, file_type)}
        assert found.keys() == given_table.keys()
        for name, one in given_table.items():
            close(found[name], one, 1e-15)
            assert found[name].on == (one.on or VERTICES)


def test_of_a_name_that_both_have_ply_gives_the_values_of_vertices() -> None:
    part = table(0)["part"]
    other = Attribute("part", np.zeros(MESH.n_faces, dtype=np.int64), on=FACES)
    (found,) = read_attributes(write_attributes([], "ply", surface_with(part, other)), "ply")
    assert found.on == VERTICES
    np.testing.assert_array_equal(found.values, part.values)


def test_groups_objects_and_materials_of_obj_are_labels_of_faces() -> None:
    lines = ["v 0 0 0", "v 1 0 0", "v 1 1 0", "v 0 1 0", "v 2 0 0", "o body", "f 1 2 3"]
    lines += ["usemtl skin", "g left arm", "f 1 3 4", "usemtl", "f 2 5 3"]
    found = read_attributes("\n".join(lines).encode(), "obj")
    assert {one.name: one.values.tolist() for one in found} == {
        "group": ["", "left arm", "left arm"],
        "material": ["", "skin", ""],
    }
    assert {one.on for one in found} == {FACES}
    segment = of_faces(3)["segment"]
    text = write_attributes([segment], "obj", surface_with(segment))
    (group,) = read_attributes(text, "obj")
    # Faces are written group by group.
    assert group.values.tolist() == [f"segment_{label}" for label in np.sort(segment.values)]


def test_obj_has_groups_of_labels_of_faces() -> None:
    segment = of_faces(3)["segment"]
    text = write_attributes([segment], "obj", surface_with(segment)).decode()
    found: dict[str, list[tuple[int, ...]]] = {}
    for line in text.splitlines():
        words = line.split()
        if words[0] == "g":
            group = found.setdefault(words[1], [])
        elif words[0] == "f":
            group.append(tuple(int(word) - 1 for word in words[1:]))
    for label in range(9):
        expected = MESH.faces[segment.values == label].tolist()
        assert found[f"segment_{label}"] == [tuple(face) for face in expected]
    with pytest.raises(TransferError, match="OBJ cannot hold 'colors'"):
        write_attributes([], "obj", surface_with(of_faces(0)["colors"]))


def test_groups_of_obj_have_different_names() -> None:
    texts = ["a b", "a_b", "b", "a  b", "", " "]
    vertices, faces = np.eye(3), np.tile([[0, 1, 2]], (6, 1))
    label = Attribute("l", np.array(texts), on=FACES)
    data = write_attributes([], "obj", WrittenSurface("s", vertices, faces, (label,)))
    (group,) = read_attributes(data, "obj")
    expected = {
        "": "l_",
        " ": "l__",
        "a  b": "l_a_b_",
        "a b": "l_a_b__",
        "a_b": "l_a_b",
        "b": "l_b",
    }
    assert group.values.tolist() == [expected[text] for text in sorted(texts)]


@pytest.mark.parametrize("names", [["height", "weights"], ["colors"]])
def test_glb_has_smooth_normals_and_is_no_metal(names: list[str]) -> None:
    """Surfaces with colours have no material, where trimesh would not show them."""
    given_table = table(3)
    data = write_attributes([], "glb", surface_with(*(given_table[name] for name in names)))
    tree = read_glb_with(data, lambda file: file.tree)
    (primitive,) = tree["meshes"][0]["primitives"]
    normals = read_glb_with(data, lambda file: file.normalised(primitive["attributes"]["NORMAL"]))
    np.testing.assert_allclose(normals, vertex_normals(MESH.vertices, MESH.faces), atol=1e-6)
    if "colors" in names:
        assert "materials" not in tree
    else:
        shown = tree["materials"][primitive["material"]]
        assert shown["pbrMetallicRoughness"]["metallicFactor"] == 0.0


def test_normals_of_triangles_apart_are_smooth() -> None:
    data = write_attributes([], "glb", surface_with(of_faces(4)["segment"]))
    (primitive,) = read_glb_with(data, lambda file: file.tree)["meshes"][0]["primitives"]
    normals = read_glb_with(data, lambda file: file.normalised(primitive["attributes"]["NORMAL"]))
    smooth = vertex_normals(MESH.vertices, MESH.faces)[MESH.faces]
    np.testing.assert_allclose(normals.reshape(-1, 3, 3), smooth, atol=1e-6)


def test_glb_has_vertices_of_its_own_for_each_triangle() -> None:
    faces, height = of_faces(4), table(4)["height"]
    data = write_attributes([], "glb", surface_with(faces["segment"], faces["colors"], height))
    seen: Any = trimesh.load(io.BytesIO(data), file_type="glb", process=False, force="mesh")
    np.testing.assert_allclose(seen.vertices[seen.faces], MESH.vertices[MESH.faces], atol=1e-6)
    labels = seen.vertex_attributes["_segment"].reshape(-1, 3)
    np.testing.assert_array_equal(labels, np.repeat(faces["segment"].values[:, None], 3, axis=1))
    octets = np.rint(255.0 * faces["colors"].values).repeat(3, axis=0)
    np.testing.assert_array_equal(seen.visual.vertex_colors[:, :3], octets)
    heights = seen.vertex_attributes["_height"].reshape(-1, 3)
    np.testing.assert_allclose(heights, height.values[MESH.faces], atol=1e-6)


def test_triangles_have_the_values_of_the_polygons_that_they_were_cut_from() -> None:
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [2, 1, 0]])
    mesh = read_mesh(mesh_files.ply(corners, [[0, 1, 2, 3], [1, 4, 5, 2]]), "ply")
    surface = WrittenSurface.of(mesh, [Attribute("part", np.array([7, 8]), on=FACES)])
    assert surface.attributes[0].values.tolist() == [7, 7, 8, 8]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("3\n1\n2\n", [3, 1, 2]),
        ("1.000000000000000000e+00\r\n-2.0e+00\r\n", [1, -2]),
        ("0.5\n1\n", [0.5, 1.0]),
        ("3\n\n2\nNaN\n", [3, -1, 2, -1]),
        ("head\n left arm \nhead", ["head", "left arm", "head"]),
        ("a\x0cb\r\nc\u2028d\re", ["a\x0cb", "c\u2028d", "e"]),
    ],
)
def test_lists_of_labels(text: str, expected: list[Any]) -> None:
    for file_type in ("seg", "txt"):
        (found,) = read_attributes(text.encode(), file_type)
        assert (found.name, found.on, found.values.tolist()) == ("label", None, expected)


def test_a_column_of_face_numbers_orders_the_rows() -> None:
    (found,) = read_attributes(b"face,a\n2,7\n0,5\n1,6\n", "csv")
    assert (found.on, found.values.tolist()) == (FACES, [5, 6, 7])
