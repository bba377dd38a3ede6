"""Attributes of GLB files of several meshes, which need not have the same."""

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from solver.arrays import npz_bytes
from solver.errors import TransferError
from solver.mesh import read_mesh
from solver.transfer import SKINNING, selected
from solver.transfer.files import WrittenSurface, read_attributes, write_glb, write_npz
from solver.transfer.files.glb_file import GlbFile

TRIANGLE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4")


def appended_node(
    file: GlbFile, values: dict[str, npt.NDArray[Any]], skin: int | None = None
) -> None:
    """A node with a mesh of one triangle that has these attributes."""
    whole = {"COLOR_0": {"normalized": True}}
    attributes = {
        name: file.accessor(one, **whole.get(name, {}))
        for name, one in {"POSITION": TRIANGLE, **values}.items()
    }
    mesh = file.append("meshes", {"primitives": [{"attributes": attributes}]})
    node = {"mesh": mesh} if skin is None else {"mesh": mesh, "skin": skin}
    file.tree["scenes"][0]["nodes"].append(file.append("nodes", node))


def influences(joints: list[int]) -> dict[str, npt.NDArray[Any]]:
    """All vertices moved alike by these joints, in sets of four."""
    found: dict[str, npt.NDArray[Any]] = {}
    for number in range(0, len(joints), 4):
        some = np.array(joints[number : number + 4])
        found[f"JOINTS_{number // 4}"] = np.tile(some.astype("u1"), (3, 1))
        shares = np.where(some > 0, 1.0 / np.count_nonzero(joints), 0.0).astype("<f4")
        found[f"WEIGHTS_{number // 4}"] = np.tile(shares, (3, 1))
    return found


def file_with_joints(*names: str) -> GlbFile:
    """A file whose first nodes have these names."""
    file = GlbFile()
    for name in names:
        file.append("nodes", {"name": name})
    return file


def test_joints_of_several_skins_are_those_of_their_nodes() -> None:
    file = file_with_joints("hip", "head", "left eye", "right eye")
    body = file.append("skins", {"joints": [0, 1]})
    eyes = file.append("skins", {"joints": [1, 2, 3]})
    appended_node(file, influences([1, 0, 0, 0]), body)
    appended_node(file, influences([2, 1, 0, 0]), eyes)
    (found,) = read_attributes(file.to_bytes(), "glb")
    assert found.columns == ("hip", "head", "left eye", "right eye")
    np.testing.assert_array_equal(found.values[:3], np.tile([0, 1, 0, 0], (3, 1)))
    np.testing.assert_array_equal(found.values[3:], np.tile([0, 0, 0.5, 0.5], (3, 1)))


def test_joints_keep_their_parents_among_the_joints() -> None:
    file = file_with_joints("left hand", "hip", "socket", "arm", "right hand")
    # The socket is no joint: it is passed over.
    for node, children in {1: [2], 2: [3], 3: [0, 4]}.items():
        file.tree["nodes"][node]["children"] = children
    skin = file.append("skins", {"joints": [0, 1, 3, 4]})
    appended_node(file, influences([1, 2, 3, 0]), skin)
    (found,) = read_attributes(file.to_bytes(), "glb")
    assert found.columns == ("left hand", "hip", "arm", "right hand")
    assert found.parents == (2, -1, 1, 2)
    surface = WrittenSurface("s", TRIANGLE.astype(float), np.array([[0, 1, 2]]), (found,))
    data = write_glb([surface])
    (again,) = read_attributes(data, "glb")
    assert (again.columns, again.parents) == (found.columns, found.parents)
    # In the pose of the file the joints put the vertices where they are.
    np.testing.assert_allclose(read_mesh(data, "glb").vertices, TRIANGLE, atol=1e-6)
    (packed,) = read_attributes(write_npz([found]), "npz")
    assert packed.parents == found.parents
    (chosen,) = selected([packed], SKINNING, ["hip", "right hand"])
    assert chosen.parents == (-1, 0)


@pytest.mark.parametrize("parents", [[1, 0], [0, -1], [-2, 0], [2, -1], [-1], [-1.0, 0.0]])
def test_parents_that_are_no_tree_are_refused(parents: list[int]) -> None:
    arrays = {"weights": np.ones((3, 2)), "joint_parents": np.array(parents)}
    with pytest.raises(TransferError, match="`joint_parents` must have"):
        read_attributes(npz_bytes(arrays), "npz")


def test_joints_of_one_name_or_none_are_told_apart() -> None:
    file = file_with_joints("arm", "", "arm", "arm_2", "hand")
    skin = file.append("skins", {"joints": [0, 1, 2, 3, 4]})
    appended_node(file, influences([1, 2, 3, 4]), skin)
    (found,) = read_attributes(file.to_bytes(), "glb")
    assert found.columns == ("arm", "joint1", "arm_2", "arm_2_3", "hand")


def test_a_mesh_that_two_nodes_show_has_the_joints_of_each() -> None:
    file = file_with_joints("a", "b", "c")
    skins = [file.append("skins", {"joints": joints}) for joints in ([0, 1], [0, 2])]
    appended_node(file, influences([1, 0, 0, 0]), skins[0])
    again = file.append("nodes", {"mesh": 0, "skin": skins[1]})
    file.tree["scenes"][0]["nodes"].append(again)
    (found,) = read_attributes(file.to_bytes(), "glb")
    np.testing.assert_array_equal(found.values.argmax(axis=1), [1, 1, 1, 2, 2, 2])


def test_meshes_may_have_different_numbers_of_joints_a_vertex_or_none() -> None:
    file = file_with_joints(*(f"j{number}" for number in range(8)))
    skin = file.append("skins", {"joints": [*range(8)]})
    appended_node(file, influences([1, 0, 0, 0]), skin)
    appended_node(file, influences([1, 2, 3, 4, 5, 0, 0, 0]), skin)
    appended_node(file, {})
    appended_node(file, influences([1, 0, 0, 0]))  # joints without a skin move nothing
    (found,) = read_attributes(file.to_bytes(), "glb")
    assert (found.name, found.values.shape) == ("weights", (12, 8))
    np.testing.assert_allclose(found.values.sum(axis=1), [1.0] * 6 + [0.0] * 6, atol=1e-6)
    np.testing.assert_allclose(found.values[3:6, 1:6], 0.2, atol=1e-7)


def test_joints_of_no_skin_have_numbers() -> None:
    file = GlbFile()
    appended_node(file, influences([2, 0, 0, 0]))
    appended_node(file, influences([1, 2, 3, 4, 5, 0, 0, 0]))
    (found,) = read_attributes(file.to_bytes(), "glb")
    assert found.columns == tuple(f"joint{number}" for number in range(6))
    assert (found.values[:3, 2] == 1.0).all()


def test_colours_with_and_without_transparency_are_joined_and_others_are_missing() -> None:
    file = GlbFile()
    appended_node(file, {"COLOR_0": np.full((3, 3), 255, np.uint8)})
    appended_node(file, {"COLOR_0": np.zeros((3, 4), np.uint8), "_part": np.ones(3, "<f4")})
    appended_node(file, {})
    colors, part = read_attributes(file.to_bytes(), "glb")
    assert colors.columns == ("red", "green", "blue", "alpha")
    np.testing.assert_array_equal(colors.values[:3], 1.0)
    np.testing.assert_array_equal(colors.values[3:6], 0.0)
    assert np.isnan(colors.values[6:]).all()
    np.testing.assert_array_equal(part.values[3:6], 1.0)
    assert np.isnan(np.delete(part.values, [3, 4, 5])).all()
