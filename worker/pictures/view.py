"""Views of shapes, which records of shapes have, so that the page and the client need no others."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import minimum_spanning_tree
from scipy.spatial.transform import Rotation

from broker.contracts import UPRIGHT, ViewAxes
from broker.contracts import View as Side
from solver.arrays import BoolArray, FloatArray, IntArray
from solver.prototype import Prototype

_THIN = 0.75
"""Cosine above which an axis is the thin direction; at most one axis exceeds it (> 1/sqrt 2)."""

_BASE = 0.2
"""Share of the height, from the bottom, whose vertices are the base of a shape."""

_TILT = 2.0
"""Factor by which squared distances must fall for a target to be tilted."""

_ROUNDING = 1e-9
"""Squared distances, of points of unit spread, that are aligned."""

_DECIMALS = 6
"""Of directions in records."""

_TURNS: Mapping[Side, FloatArray] = MappingProxyType(
    {
        "front": np.eye(3),
        "back": np.array([[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]),
        "left": np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]),
        "right": np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]),
        "top": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
        "bottom": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]),
    }
)
"""Rotations of the paper that bring a side of what is seen from the front towards the reader."""


@dataclass(frozen=True, eq=False)
class View:
    """A rotation from a shape's coordinates to the paper's.

    Parameters
    ----------
    axes
        (3, 3) rows: the direction to the right, the one up, and the one towards the reader.
    """

    axes: FloatArray

    def of(self, points: FloatArray) -> FloatArray:
        """(K, 3) points in the paper's coordinates."""
        seen: FloatArray = points @ self.axes.T
        return seen

    def rows(self) -> ViewAxes:
        """The axes as records have them."""
        # No negative zeros.
        right, up, towards = map(tuple, (self.axes.round(_DECIMALS) + 0.0).tolist())
        return right, up, towards

    def seen_from(self, side: Side) -> "View":
        """Return the view from another side; this one is from the front, left is the viewer's."""
        return View(_TURNS[side] @ self.axes)


def source_view(vertices: FloatArray, faces: IntArray) -> View:
    """Return the view along the thinnest direction of a shape, with its y or z axis vertical.

    Files have either axis up, or down. Of the axes along which the shape is not thin, the one is
    chosen whose lower end has the most widely spread vertices; the shape is turned over if it then
    stands better.

    Parameters
    ----------
    vertices, faces
        (V, 3), of any size, and (F, 3).
    """
    size = float(np.ptp(vertices, axis=0).max()) or 1.0
    vertices = (vertices - vertices.min(axis=0)) / size
    thin = np.linalg.eigh(np.cov(vertices.T))[1][:, 0]
    upright = [axis for axis in (1, 2) if abs(thin[axis]) <= _THIN]
    axis = max(upright, key=lambda axis: _support(vertices, axis))
    up = np.eye(3)[axis] * (-1.0 if _stands_on_its_head(vertices, faces, axis) else 1.0)
    towards = thin - (thin @ up) * up
    towards /= np.linalg.norm(towards)
    # Eigenvectors have no sign: face the positive side of the axis that is nearest.
    towards *= np.sign(towards[np.argmax(np.abs(towards))])
    return View(np.stack([np.cross(up, towards), up, towards]))


def prototype_view(prototype: Prototype) -> View:
    """Return the view of the first surface of a prototype; y is up if it has none."""
    if not prototype.surfaces:
        return View(np.array(UPRIGHT))
    return source_view(prototype.surfaces[0].vertices, prototype.surfaces[0].faces)


def _support(vertices: FloatArray, axis: int) -> float:
    """Spread of the lowest vertices when an axis points up."""
    height = vertices[:, axis]
    lowest = height <= height.min() + 0.1 * np.ptp(height)
    return float(np.delete(vertices[lowest], axis, axis=1).std(axis=0).sum())


def _stands_on_its_head(vertices: FloatArray, faces: IntArray, axis: int) -> bool:
    """Whether a shape stands better upside down, by all that bodies on their feet have in common.

    Their weight is high, their base is broad, and limbs hang from them.
    """
    height = vertices[:, axis]
    up, down = height - height.min(), height.max() - height
    limit = _BASE * up.max()
    return bool(
        down.mean() > up.mean()
        and _base(vertices, axis, down <= limit) > _base(vertices, axis, up <= limit)
        and _limbs(down, faces) > _limbs(up, faces)
    )


def _base(vertices: FloatArray, axis: int, lowest: BoolArray) -> float:
    """Squared area, but for a factor, of the ellipse of the lowest vertices."""
    flat = np.delete(vertices[lowest], axis, axis=1)
    centred = flat - flat.mean(axis=0)
    return float(np.linalg.det(centred.T @ centred / len(flat)))


def _limbs(height: FloatArray, faces: IntArray) -> float:
    """How far limbs hang: the total persistence of components of sublevel sets, but for a constant.

    A component begins at a vertex, and ends at an edge of the minimum spanning tree by the heights
    of upper ends.
    """
    ends = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    keys = np.sort(ends[:, 0] * len(height) + ends[:, 1])
    first, second = divmod(keys[np.diff(keys, prepend=-1) > 0], len(height))
    # Of heights from 1, as edges of weight 0 are none.
    upper = 1.0 + np.maximum(height[first], height[second])
    tree = minimum_spanning_tree(coo_array((upper, (first, second)), shape=(len(height),) * 2))
    used = np.zeros(len(height), dtype=bool)
    used[faces] = True
    return float(tree.sum() - height[used].sum())


def target_view(view: View, source_points: FloatArray, target_points: FloatArray) -> View:
    """Return the view of a target in which its matched points are nearest to those of the source.

    Shapes that stand upright stay so: the target is rotated about the vertical, unless a rotation
    about another axis brings its points much nearer, as where files have different axes up.

    Parameters
    ----------
    view
        View of the source.
    source_points, target_points
        (K, 3) matched points of both shapes.
    """
    seen, other = (_of_unit_spread(view.of(points)) for points in (source_points, target_points))
    turn = np.angle(np.vdot(other[:, 0] + 1j * other[:, 2], seen[:, 0] + 1j * seen[:, 2]))
    cosine, sine = np.cos(turn), np.sin(turn)
    upright = np.array([[cosine, 0.0, -sine], [0.0, 1.0, 0.0], [sine, 0.0, cosine]])
    free, _ = Rotation.align_vectors(seen, other)
    apart, least = (
        float(((other @ turn.T - seen) ** 2).sum()) for turn in (upright, free.as_matrix())
    )
    tilted = apart > _TILT * least + _ROUNDING
    return View((free.as_matrix() if tilted else upright) @ view.axes)


def _of_unit_spread(points: FloatArray) -> FloatArray:
    centred = points - points.mean(axis=0)
    spread: FloatArray = centred / max(float(centred.std()), 1e-300)
    return spread
