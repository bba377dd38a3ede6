"""Views of shapes in pictures."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from broker.contracts import View as Side
from solver.arrays import FloatArray

_THIN = 0.75
"""Cosine above which an axis is the thin direction; at most one axis exceeds it (> 1/sqrt 2)."""


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
    """Return the view of a target, rotated about the vertical to align matched points.

    Parameters
    ----------
    view
        View of the source.
    source_points, target_points
        (K, 3) matched points of both shapes, centred.
    """
    seen, other = view.of(source_points), view.of(target_points)
    flat = np.stack([seen[:, 0] + 1j * seen[:, 2], other[:, 0] + 1j * other[:, 2]])
    flat = flat - flat.mean(axis=1, keepdims=True)
    turn = np.angle(np.vdot(flat[1], flat[0]))
    cosine, sine = np.cos(turn), np.sin(turn)
    rotation = np.array([[cosine, 0.0, -sine], [0.0, 1.0, 0.0], [sine, 0.0, cosine]])
    return View(rotation @ view.axes)
