"""Initial camera of a shape in a figure: the shape upright, seen from its broad side."""

from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from isomatch._figures.colors import Floats

_THIN: Final = 0.75
"""An axis at this cosine or more to the thinnest direction is not vertical; above 1/sqrt(2), so
that at most one axis is excluded."""

_FOOT: Final = 0.1
"""Share of the height, from the bottom, whose vertices a shape stands on."""

_DISTANCE: Final = 1.3
"""Distance of the camera, in sides of the cube that the shape fills."""


@dataclass(frozen=True)
class Camera:
    """Position of the camera around a shape.

    Attributes
    ----------
    up
        Vertical axis of the shape's file: 1 for y, 2 for z.
    azimuth
        Angle about that axis, in radians, from the axis that follows it cyclically.
    """

    up: int
    azimuth: float

    @classmethod
    def of_shape(cls, vertices: Floats) -> "Camera":
        """Look along the horizontal direction in which a shape is thinnest.

        The vertical is y or z, the two conventions of mesh files: the one on whose lower end the
        shape has the wider support.

        Parameters
        ----------
        vertices
            (V, 3), at least two.
        """
        centred = vertices - vertices.mean(axis=0)
        thin = np.linalg.eigh(centred.T @ centred)[1][:, 0]
        vertical = [axis for axis in (1, 2) if abs(thin[axis]) <= _THIN]
        up = max(vertical, key=lambda axis: _support(vertices, axis))
        thin[up] = 0.0
        # Eigenvectors have no sign: look at the positive side of the nearest axis.
        thin *= np.sign(thin[np.argmax(np.abs(thin))])
        return cls(up, float(np.arctan2(thin[(up + 2) % 3], thin[(up + 1) % 3])))

    def aligned(self, other: "Camera", points: Floats, other_points: Floats) -> "Camera":
        """Camera of another shape that shows corresponding points as this camera does.

        The least-squares rotation about the vertical is applied. Shapes with different vertical
        axes, or with fewer than three corresponding points, keep their `other` camera.

        Parameters
        ----------
        other
            Camera of the other shape by itself.
        points, other_points
            (n, 3) corresponding points on both shapes.
        """
        if self.up != other.up or len(points) < 3:
            return other
        first, second = (self.up + 1) % 3, (self.up + 2) % 3
        here, there = (
            flat - flat.mean()
            for flat in (each[:, first] + 1j * each[:, second] for each in (points, other_points))
        )
        return Camera(self.up, self.azimuth + float(np.angle(np.vdot(here, there))))

    def direction(self) -> Floats:
        """Unit vector from the shape to the viewer, (3,)."""
        towards = np.zeros(3)
        towards[(self.up + 1) % 3], towards[(self.up + 2) % 3] = (
            np.cos(self.azimuth),
            np.sin(self.azimuth),
        )
        return towards

    def to_plotly(self) -> dict[str, Any]:
        """The camera as plotly's ``layout.scene.camera``."""
        axes = dict(zip("xyz", np.eye(3)[self.up].tolist(), strict=True))
        eye = dict(zip("xyz", (_DISTANCE * self.direction()).tolist(), strict=True))
        return {"up": axes, "eye": eye}


def _support(vertices: Floats, axis: int) -> float:
    """Spread of the lowest vertices when an axis points up."""
    height = vertices[:, axis]
    lowest = height <= height.min() + _FOOT * np.ptp(height)
    return float(np.delete(vertices[lowest], axis, axis=1).std(axis=0).sum())
