"""Poses, and the near-isometric deformation that puts a figure into one."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu
from scipy.spatial.transform import Rotation

from solver.arrays import FloatArray, IntArray
from synthetic.implicit import cone_distances
from synthetic.skeleton import Figure, other_side

Angles = tuple[float, float, float]
"""Turns about x, then y, then z (the axes of the rest pose), in degrees."""


@dataclass(frozen=True)
class Pose:
    """Rotations of joints from the rest pose.

    Parameters
    ----------
    turns
        (joint, angles) pairs; joints that are not named keep the rest pose. Rotations are relative
        to the parent's.
    """

    turns: tuple[tuple[str, Angles], ...] = ()

    def mirrored(self) -> "Pose":
        """The same pose with left and right exchanged."""
        return Pose(tuple((other_side(name), (x, -y, -z)) for name, (x, y, z) in self.turns))


REST = Pose()


def joint_transforms(figure: Figure, pose: Pose) -> tuple[FloatArray, FloatArray]:
    """Rigid motion that each joint gives to what follows it.

    Parameters
    ----------
    figure
        In its rest pose, J joints.
    pose
        The turns.

    Returns
    -------
    rotations, translations
        (J, 3, 3) and (J, 3) float64: a point x goes to ``R x + t``.

    Raises
    ------
    KeyError
        The pose names a joint that the figure does not have.
    """
    index = figure.joint_index()
    turns = {index[name]: angles for name, angles in pose.turns}
    rotations = np.empty((len(figure.joints), 3, 3))
    translations = np.empty((len(figure.joints), 3))
    for j, joint in enumerate(figure.joints):
        own = Rotation.from_euler("xyz", turns.get(j, (0.0, 0.0, 0.0)), degrees=True).as_matrix()
        centre = np.array(joint.position)
        rotations[j], translations[j] = own, centre - own @ centre
        if joint.parent is not None:
            up = index[joint.parent]
            translations[j] = rotations[up] @ translations[j] + translations[up]
            rotations[j] = rotations[up] @ own
    return rotations, translations


def skinning_weights(figure: Figure, points: FloatArray, width: float) -> FloatArray:
    """Share of each joint in the motion of points.

    Parameters
    ----------
    figure
        J joints.
    points
        (V, 3) float64, in the rest pose.
    width
        Distance over which the weight passes from one cone of flesh to the next, in metres.

    Returns
    -------
    weights
        (V, J) float64, rows summing to 1.
    """
    cones = figure.cones()
    distances = cone_distances(cones, points)
    shares = np.exp((distances.min(axis=1, keepdims=True) - distances) / width)
    weights = np.zeros((len(points), len(figure.joints)))
    np.add.at(weights.T, cones.joint, shares.T)
    weights /= weights.sum(axis=1, keepdims=True)
    return weights


class Deformation:
    """Puts a surface into poses: linear blend skinning, then as rigid as possible.

    Skinning alone shrinks bent joints; a few steps of the as-rigid-as-possible energy
    (Sorkine and Alexa 2007), held softly to the skinned positions, give edges their lengths back.

    Parameters
    ----------
    figure
        In its rest pose.
    vertices, faces
        (V, 3) float64 and (F, 3) int64, its surface.
    hold
        Weight of the skinned positions against that of the edges, per vertex.
    steps
        Alternations of local rotations and global solve.
    """

    def __init__(
        self,
        figure: Figure,
        vertices: FloatArray,
        faces: IntArray,
        hold: float = 0.02,
        steps: int = 8,
    ) -> None:
        self._figure = figure
        self._rest = vertices
        self._hold = hold
        self._steps = steps
        self._weights = skinning_weights(figure, vertices, width=0.025)
        self._tail, self._head, self._stiffness = _cotangent_edges(vertices, faces)
        n = len(vertices)
        entries = sparse.csc_array((self._stiffness, (self._tail, self._head)), shape=(n, n))
        diagonal = np.asarray(entries.sum(axis=1)).ravel() + hold
        self._factor = splu(
            sparse.csc_array(sparse.diags_array(diagonal) - entries),
            permc_spec="MMD_AT_PLUS_A",
            options={"SymmetricMode": True},
        )

    def __call__(self, pose: Pose) -> FloatArray:
        """Vertices in a pose.

        Parameters
        ----------
        pose
            The turns of the joints.

        Returns
        -------
        vertices
            (V, 3) float64.
        """
        rotations, translations = joint_transforms(self._figure, pose)
        turned = np.einsum("jab,vb->vja", rotations, self._rest) + translations
        skinned = np.einsum("vj,vja->va", self._weights, turned)
        vertices: FloatArray = skinned
        rest_edges = self._rest[self._tail] - self._rest[self._head]
        for _ in range(self._steps):
            local = self._local_rotations(vertices, rest_edges)
            turned_edges = 0.5 * np.einsum(
                "eab,eb->ea", local[self._tail] + local[self._head], rest_edges
            )
            right = self._gather(self._stiffness[:, None] * turned_edges)
            vertices = self._factor.solve(right + self._hold * skinned)
        return vertices

    def _local_rotations(self, vertices: FloatArray, rest_edges: FloatArray) -> FloatArray:
        edges = vertices[self._tail] - vertices[self._head]
        moments = self._stiffness[:, None, None] * rest_edges[:, :, None] * edges[:, None, :]
        u, _, vt = np.linalg.svd(self._gather(moments.reshape(-1, 9)).reshape(-1, 3, 3))
        u[:, :, 2] *= np.sign(np.linalg.det(u @ vt))[:, None]
        rotations: FloatArray = np.swapaxes(u @ vt, 1, 2)
        return rotations

    def _gather(self, values: FloatArray) -> FloatArray:
        """Sum the values of directed edges at their tails."""
        columns = [
            np.bincount(self._tail, values[:, k], minlength=len(self._rest))
            for k in range(values.shape[1])
        ]
        return np.stack(columns, axis=1)


def _cotangent_edges(
    vertices: FloatArray, faces: IntArray
) -> tuple[IntArray, IntArray, FloatArray]:
    """Directed edges with half the cotangents of their opposite angles, clipped at 0.05."""
    tails, heads, cotangents = [], [], []
    for k in range(3):
        a, b, c = faces[:, k], faces[:, (k + 1) % 3], faces[:, (k + 2) % 3]
        u, v = vertices[a] - vertices[c], vertices[b] - vertices[c]
        cross = np.linalg.norm(np.cross(u, v), axis=1)
        cotangent = 0.5 * np.einsum("fd,fd->f", u, v) / np.maximum(cross, 1e-15)
        tails += [a, b]
        heads += [b, a]
        cotangents += [cotangent, cotangent]
    tail, head = np.concatenate(tails), np.concatenate(heads)
    n = len(vertices)
    summed = sparse.coo_array((np.concatenate(cotangents), (tail, head)), shape=(n, n))
    entries = summed.tocsr().tocoo()
    tail, head = entries.coords[0].astype(np.int64), entries.coords[1].astype(np.int64)
    return tail, head, np.maximum(entries.data, 0.05)
