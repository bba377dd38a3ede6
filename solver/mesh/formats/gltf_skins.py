"""Skins of glTF: the joints that move each vertex, and where they put it."""

from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.errors import MeshError
from solver.mesh.formats.gltf_data import GltfData
from solver.mesh.formats.gltf_scene import Scene

_SAME: Final = 1e-5
"""Distance, in extents, up to which all joints move a shape alike: inverse bind matrices are in
single precision, and vertices in the same position are to stay there."""


def influences(data: GltfData, attributes: Any) -> tuple[IntArray, FloatArray] | None:
    """Read the joints of the vertices of a primitive, numbered as its skin numbers them.

    Parameters
    ----------
    data
        The file.
    attributes
        Of the primitive.

    Returns
    -------
    (V, k) joints, and (V, k) their weights; ``None`` without. A joint of weight 0 is joint 0.

    Raises
    ------
    MeshError
        There are not as many joints as weights, or not for every vertex.
    """
    sets = [name.removeprefix("JOINTS_") for name in attributes if name.startswith("JOINTS_")]
    if not sets:
        return None
    joints = np.hstack([data.values(attributes[f"JOINTS_{one}"]) for one in sets])
    weights = np.hstack([data.normalised(attributes[f"WEIGHTS_{one}"]) for one in sets])
    rows = data.entry("accessors", attributes["POSITION"])["count"]
    if joints.shape != weights.shape or len(joints) != rows or joints.dtype.kind not in "iu":
        raise MeshError("the glTF file does not have joints and weights for every vertex")
    return np.where(weights == 0.0, 0, joints).astype(np.int64), weights


def joint_nodes(data: GltfData, skin: int) -> list[int]:
    """Return the nodes that are the joints of a skin.

    Raises
    ------
    MeshError
        The skin or a node does not exist.
    """
    joints: list[int] = data.entry("skins", skin)["joints"]
    for joint in joints:
        data.entry("nodes", joint)
    return joints


def check_joints(joints: IntArray, count: int) -> None:
    """Refuse joints that a skin of so many does not have.

    Raises
    ------
    MeshError
        A number is negative or too large.
    """
    if joints.size and (joints.min() < 0 or joints.max() >= count):
        wrong = joints[(joints < 0) | (joints >= count)].flat[0]
        raise MeshError(f"joint {wrong} does not exist; the skin of the glTF file has {count}")


@dataclass(frozen=True, eq=False)
class GltfSkins:
    """The skins of a glTF file, each read once.

    Parameters
    ----------
    data
        The file.
    scene
        What it shows.
    """

    data: GltfData
    scene: Scene
    _matrices: dict[int, FloatArray] = field(default_factory=dict)
    _inverse: dict[int, FloatArray] = field(default_factory=dict)

    def matrices(self, skin: int) -> FloatArray:
        """Return the (J, 4, 4) matrices by which the joints of a skin move its mesh.

        Raises
        ------
        MeshError
            The skin has no joints, or not an inverse bind matrix for each.
        """
        if skin not in self._matrices:
            joints = joint_nodes(self.data, skin)
            if not joints:
                raise MeshError("a skin of the glTF file has no joints; it is damaged")
            placed = np.stack([self.scene.transforms[joint] for joint in joints])
            known = self.data.entry("skins", skin)
            if "inverseBindMatrices" in known:
                placed = placed @ self._inverse_of(known["inverseBindMatrices"], len(joints))
            self._matrices[skin] = placed
        return self._matrices[skin]

    def _inverse_of(self, accessor: int, count: int) -> FloatArray:
        if accessor not in self._inverse:
            # Stored column by column.
            stored = self.data.values(accessor).astype(np.float64).reshape(-1, 4, 4)
            self._inverse[accessor] = stored.transpose(0, 2, 1)
        found = self._inverse[accessor][:count]
        if len(found) < count or not np.isfinite(found).all():
            raise MeshError("a skin of the glTF file has no matrix for every joint; it is damaged")
        return found


def skinned(
    vertices: FloatArray, joints: IntArray, weights: FloatArray, matrices: FloatArray
) -> FloatArray:
    """Move vertices by their joints (linear blend skinning).

    Parameters
    ----------
    vertices
        (V, 3).
    joints, weights
        (V, k).
    matrices
        (J, 4, 4).

    Returns
    -------
    (V, 3). Vertices of no weight go with the first joint.
    """
    first = matrices[0]
    rigid: FloatArray = vertices @ first[:3, :3].T + first[:3, 3]
    sums = weights.sum(axis=1)
    moved = np.where(sums == 0.0, 1.0, 0.0)[:, None] * rigid
    shares = weights / np.where(sums == 0.0, 1.0, sums)[:, None]
    for joint, share in zip(joints.T, shares.T, strict=True):
        own = matrices[joint]
        moved += share[:, None] * (
            np.einsum("nij,nj->ni", own[:, :3, :3], vertices) + own[:, :3, 3]
        )
    apart = float(np.abs(moved - rigid).max(initial=0.0))
    extent = float(np.ptp(rigid, axis=0).max()) if len(rigid) else 0.0
    return rigid if apart <= _SAME * extent else moved
