"""Point clouds as text: columns, separators, headers, and what is refused."""

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from solver.arrays import FloatArray
from solver.errors import MeshError
from solver.mesh import read_mesh
from solver.mesh.formats.xyz import read_xyz

POINTS = np.array([[0.0, 0, 0], [1, 0, 0.5], [1, -1, 0], [0, 1, 2.25]])
NORMALS = np.array([[0.0, 0, 1], [1, 0, 0], [0.6, 0.8, 0], [0, -1, 0]])
COLORS = np.array([[255.0, 0, 0], [0, 128, 0], [0, 0, 64], [255, 255, 255]])


def text(table: FloatArray, separator: str = " ", header: str = "") -> bytes:
    lines = [separator.join(f"{number:g}" for number in row) for row in table]
    return (header + "\n".join(lines) + "\n").encode()


@pytest.mark.parametrize("separator", [" ", ",", ";", "\t", ", "])
@pytest.mark.parametrize("header", ["", "x,y,z\n", "4\n", "# by hand\n\n", "// scan\n"])
def test_points_are_read_in_their_order(separator: str, header: str) -> None:
    found = read_xyz(text(POINTS, separator, header))
    np.testing.assert_array_equal(found.vertices, POINTS)
    np.testing.assert_array_equal(found.vertex_ids, np.arange(4))
    assert found.is_cloud
    assert len(found.faces) == 0
    assert found.normals is None
    assert found.colors is None


def test_further_columns_are_normals_or_colours() -> None:
    found = read_xyz(text(np.hstack([POINTS, NORMALS])))
    assert found.normals is not None
    np.testing.assert_allclose(found.normals, NORMALS)
    assert found.colors is None
    found = read_xyz(text(np.hstack([POINTS, COLORS])))
    assert found.normals is None
    assert found.colors is not None
    np.testing.assert_allclose(found.colors, COLORS / 255.0)
    found = read_xyz(text(np.hstack([POINTS, 1000.0 * COLORS])))
    assert found.normals is None
    assert found.colors is None


@pytest.mark.parametrize("header", ["", "4\n"])
def test_of_seven_columns_the_fourth_is_the_intensity(header: str) -> None:
    intensity = np.array([[-1200.0], [12], [80], [255]])
    found = read_xyz(text(np.hstack([POINTS, intensity, COLORS]), header=header))
    assert found.normals is None
    assert found.colors is not None
    np.testing.assert_allclose(found.colors, COLORS / 255.0)
    found = read_xyz(text(np.hstack([POINTS, NORMALS, intensity]), header=header))
    assert found.normals is not None
    np.testing.assert_allclose(found.normals, NORMALS)
    assert read_xyz(text(np.hstack([POINTS, intensity]), header=header)).colors is None


@given(
    st.integers(0, 2**31 - 1),
    st.sampled_from(["nc", "cn", "inc", "icn", "nic", "cin", "nci", "cni"]),
    st.booleans(),
)
def test_normals_and_colours_are_found_by_their_values(seed: int, order: str, whole: bool) -> None:
    rng = np.random.default_rng(seed)
    normals = rng.standard_normal((12, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    colors = rng.integers(0, 256, (12, 3)) / 255.0
    intensity = rng.uniform(-2048.0, 2047.0, (12, 1))
    columns = {"n": normals, "c": np.rint(255.0 * colors) if whole else colors, "i": intensity}
    found = read_xyz(text(np.hstack([normals, *(columns[one] for one in order)])))
    assert found.normals is not None
    np.testing.assert_allclose(found.normals, normals, atol=1e-5)
    assert found.colors is not None
    np.testing.assert_allclose(found.colors, colors, atol=1e-5)


def test_pts_has_the_intensity_first_where_values_do_not_say_so() -> None:
    table = np.hstack([POINTS, COLORS[:, :1], COLORS, NORMALS])
    found = read_xyz(text(table, header="4\n"))
    assert found.colors is not None
    np.testing.assert_allclose(found.colors, COLORS / 255.0)
    assert found.normals is not None
    np.testing.assert_allclose(found.normals, NORMALS)
    with pytest.raises(MeshError, match="a point has 10 numbers, and their values do not say"):
        read_xyz(text(table))


UNKNOWN = 1000.0 * COLORS
AXES = np.eye(3)[[0, 1, 2, 0]]


def test_columns_after_normals_may_be_anything_but_a_colour() -> None:
    for more in (UNKNOWN[:, :2], UNKNOWN, np.hstack([UNKNOWN, UNKNOWN])):
        found = read_xyz(text(np.hstack([POINTS, NORMALS, more])))
        assert found.normals is not None
        np.testing.assert_allclose(found.normals, NORMALS)
        assert found.colors is None


@pytest.mark.parametrize(
    "columns",
    [
        (COLORS, COLORS),
        (AXES, AXES[::-1]),  # both of length 1, and in 0..1
        (UNKNOWN[:, :2], COLORS),
        (COLORS, UNKNOWN),
        (UNKNOWN, NORMALS),
        (COLORS, COLORS, COLORS),
    ],
)
@pytest.mark.parametrize("header", ["", "4\n", "my scan\n"])
def test_columns_whose_values_do_not_say_what_they_are_have_to_be_named(
    columns: Sequence[FloatArray], header: str
) -> None:
    table = np.hstack([POINTS, *columns])
    with pytest.raises(MeshError, match=r"expected x y z.* name the columns in the first line"):
        read_xyz(text(table, header=header))
    names = ["x", "y", "z", *(f"c{place}" for place in range(table.shape[1] - 3))]
    np.testing.assert_allclose(
        read_xyz(text(table, header=" ".join(names) + "\n")).vertices, POINTS
    )


TABLES = arrays(
    np.float64,
    st.tuples(st.integers(1, 5), st.just(3)),
    elements=st.floats(-1e6, 1e6).map(lambda number: round(number, 3)),
)


@given(TABLES, st.sampled_from([";", "\t", " ", " ; ", "   "]), st.booleans())
def test_decimal_commas_are_read_where_another_separator_is(
    points: FloatArray, separator: str, named: bool
) -> None:
    lines = (separator.join(f"{number!r}" for number in row) for row in points.tolist())
    written = "\n".join(line.replace(".", ",") for line in lines) + "\n"
    found = read_xyz((f"x{separator}y{separator}z\n" * named + written).encode())
    np.testing.assert_array_equal(found.vertices, points)
    assert not found.notes


@given(
    TABLES,
    st.permutations(["x", "Y", "z ", '"nx"', "ny", "Nz", "red", "green", "blue", "id", "q (mm)"]),
    st.sampled_from([("", ","), ("", ";"), ("", "\t"), ("//", ","), ("# ", ";")]),
)
def test_columns_are_found_by_name(
    points: FloatArray, header: Sequence[str], style: tuple[str, str]
) -> None:
    start, separator = style
    known = dict.fromkeys(header, 7.0 * np.ones(len(points)))
    known |= dict(zip(("x", "Y", "z "), points.T, strict=True))
    known |= dict(zip(('"nx"', "ny", "Nz"), np.resize(NORMALS, (len(points), 3)).T, strict=True))
    known |= dict(zip(("red", "green", "blue"), np.resize(COLORS, points.shape).T, strict=True))
    rows = np.stack([known[name] for name in header], axis=1).tolist()
    lines = (separator.join(map(repr, row)) for row in rows)
    found = read_xyz((start + separator.join(header) + "\n" + "\n".join(lines) + "\n").encode())
    np.testing.assert_array_equal(found.vertices, points)
    assert found.normals is not None
    np.testing.assert_array_equal(found.normals, np.resize(NORMALS, points.shape))
    assert found.colors is not None
    np.testing.assert_allclose(found.colors, np.resize(COLORS, points.shape) / 255.0)


@given(st.text("0123456789.,;-+e \t\nxyz#/()", max_size=60))
def test_any_text_is_read_in_full_or_refused(written: str) -> None:
    try:
        found = read_xyz(written.encode())
    except MeshError:
        return
    assert found.vertices.shape == (len(found.vertex_ids), 3)
    lines = [line for line in written.splitlines() if not line.strip().startswith(("#", "//"))]
    assert len(found.vertices) <= len(lines)


@pytest.mark.parametrize("separator", [",", ";"])
def test_separators_at_the_ends_of_lines_are_no_columns(separator: str) -> None:
    lines = (separator.join(row) + separator for row in ("zxy", "312", "645"))
    np.testing.assert_array_equal(
        read_xyz("\n".join(lines).encode()).vertices, [[1, 2, 3], [4, 5, 6]]
    )


def test_columns_of_other_names_are_no_colours() -> None:
    found = read_xyz(b"x y z intensity class id\n0 0 0 12 1 1\n1 0 0 200 2 2\n")
    assert found.colors is None
    assert found.normals is None


def test_a_header_without_x_y_and_z_is_said() -> None:
    for header in ("id,px,py,pz", "My scan", "x,y,y"):
        found = read_xyz(f"{header}\n{text(POINTS, ',').decode()}".encode())
        np.testing.assert_array_equal(found.vertices, POINTS)
        assert any("does not name columns x, y and z" in note for note in found.notes)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "empty"),
        (b"# nothing\n", "no points"),
        (b"x y z\n", "no points"),
        ("²\n".encode(), "no points"),
        (b"9" * 5000 + b"\n1 2 3\n", "point line"),
        (b"Dear reader,\nthis is a letter.\n", "point line"),
        (b"1 2\n3 4\n", "x, y and z are needed"),
        (b"1 2 3\n4 5\n", "point line"),
        (b"x,y,z\n1,2,3,4\n", "names 3 columns, but a point has 4"),
        (b"x;y;z\n1,5;2,5;1.234,5\n", "point 0, '1,5;2,5;1.234,5'"),
        (b"1 2 3\n4, 5 6\n", "point 1, '4, 5 6'"),
        (b"1,2,3 4,5,6\n", "point 0"),
        (b"1 2 3\n4 five 6\n", "point line"),
        (b"3\n1 2 3\n4 5 6\n", "promises 3 points and has 2"),
        (b"1 2 3\n4 5 6\n", "20 points or more in different places; there are 2"),
    ],
)
def test_what_is_refused(data: bytes, message: str) -> None:
    with pytest.raises(MeshError, match=message):
        read_mesh(data, "xyz")
