"""From which side shapes are looked at in figures: as in the service's own pictures."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

_THIN: Final = 0.75
"""Cosine beyond which an axis counts as the thin direction; no two axes can both exceed it."""


@dataclass(frozen=True)
class View:
    """From where a shape is seen, at the height of its middle.

    Parameters
    ----------
    up
        Which of its axes points up.
    azimuth
        Degrees about that axis, from the axis that follows it, as matplotlib counts them.
    """

    up: int
    azimuth: float

    @property
    def axes(self) -> Floats:
        """(3, 3) rows: the direction to the right, the one up, and the one towards the viewer."""
        up = np.eye(3)[self.up]
        towards = np.zeros(3)
        angle = np.radians(self.azimuth)
        towards[(self.up + 1) % 3], towards[(self.up + 2) % 3] = np.cos(angle), np.sin(angle)
        return np.stack([np.cross(up, towards), up, towards])


def own_view(vertices: Floats) -> View:
    """Look along the direction in which a shape is thinnest, with its own y or z axis up.

    Files have either axis up. Of those along which the shape is not thin, the one is taken on
    whose lower end it would stand most firmly.

    Parameters
    ----------
    vertices
        (V, 3), at least two.
    """
    centred = vertices - vertices.mean(axis=0)
    thin = np.linalg.eigh(centred.T @ centred)[1][:, 0]
    upright = [axis for axis in (1, 2) if abs(thin[axis]) <= _THIN]
    up = max(upright, key=lambda axis: _support(vertices, axis))
    thin[up] = 0.0
    # Eigenvectors have no sign: face the positive side of the axis that is nearest.
    thin *= np.sign(thin[np.argmax(np.abs(thin))])
    towards = np.arctan2(thin[(up + 2) % 3], thin[(up + 1) % 3])
    return View(up, float(np.degrees(towards)))


def _support(vertices: Floats, axis: int) -> float:
    """How far apart the lowest vertices lie, when an axis points up."""
    height = vertices[:, axis]
    lowest = height <= height.min() + 0.1 * np.ptp(height)
    return float(np.delete(vertices[lowest], axis, axis=1).std(axis=0).sum())


def turned_alike(view: View, other: View, here: Floats, there: Floats) -> View:
    """Turn another shape about the vertical, until matched points lie alike.

    Parameters
    ----------
    view, other
        How the one is looked at, and how the other would be by itself. It is, where the vertical
        is another axis of its file, or fewer than three points are matched.
    here, there
        (n, 3) matched points of both.
    """
    if view.up != other.up or len(here) < 3:
        return other
    first, second = ((view.up + step) % 3 for step in (1, 2))
    flat = [points[:, first] + 1j * points[:, second] for points in (here, there)]
    flat = [points - points.mean() for points in flat]
    turn = float(np.degrees(np.angle(np.vdot(flat[1], flat[0]))))
    return View(view.up, view.azimuth - turn)
