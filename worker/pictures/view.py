"""Views of shapes in pictures."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from scipy.spatial.transform import Rotation

from broker.contracts import View as Side
from solver.arrays import FloatArray

_THIN = 0.75
"""Cosine above which an axis is the thin direction; at most one axis exceeds it (> 1/sqrt 2)."""

_TILT = 2.0
"""Factor by which squared distances must fall for a target to be tilted."""

_ROUNDING = 1e-9
"""Squared distances, of points of unit spread, that are aligned."""

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

    def seen_from(self, side: Side) -> "View":
        """Return the view from another side; this one is from the front, left is the viewer's."""
        return View(_TURNS[side] @ self.axes)


def source_view(vertices: FloatArray) -> View:
    """Return the view along the thinnest direction of a shape, with its y or z axis up.

    Files have either axis up. Of the axes along which the shape is not thin, the one is chosen
    whose lower end has the most widely spread vertices.

    Parameters
    ----------
    vertices
        (V, 3), centred.
    """
    thin = np.linalg.eigh(np.cov(vertices.T))[1][:, 0]
    upright = [axis for axis in (1, 2) if abs(thin[axis]) <= _THIN]
    up = np.eye(3)[max(upright, key=lambda axis: _support(vertices, axis))]
    towards = thin - (thin @ up) * up
    towards /= np.linalg.norm(towards)
    # Eigenvectors have no sign: face the positive side of the axis that is nearest.
    towards *= np.sign(towards[np.argmax(np.abs(towards))])
    return View(np.stack([np.cross(up, towards), up, towards]))


def _support(vertices: FloatArray, axis: int) -> float:
    """Spread of the lowest vertices when an axis points up."""
    height = vertices[:, axis]
    lowest = height <= height.min() + 0.1 * np.ptp(height)
    return float(np.delete(vertices[lowest], axis, axis=1).std(axis=0).sum())


def target_view(view: View, source_points: FloatArray, target_points: FloatArray) -> View:
    """Return the view of a target in which its matched points are nearest to those of the source.

    Shapes that stand upright stay so: the target is rotated about the vertical, unless a rotation
    about another axis brings its points much nearer, as where files have different axes up.

    Parameters
    ----------
    view
        View of the source.
    source_points, target_points
        (K, 3) matched points of both shapes, centred.
    """
    seen, other = (
        (points - points.mean(axis=0)) / max(float(points.std()), 1e-300)
        for points in (view.of(source_points), view.of(target_points))
    )
    turn = np.angle(np.vdot(other[:, 0] + 1j * other[:, 2], seen[:, 0] + 1j * seen[:, 2]))
    cosine, sine = np.cos(turn), np.sin(turn)
    upright = np.array([[cosine, 0.0, -sine], [0.0, 1.0, 0.0], [sine, 0.0, cosine]])
    free, _ = Rotation.align_vectors(seen, other)
    apart, least = (
        float(((other @ turn.T - seen) ** 2).sum()) for turn in (upright, free.as_matrix())
    )
    tilted = apart > _TILT * least + _ROUNDING
    return View((free.as_matrix() if tilted else upright) @ view.axes)
