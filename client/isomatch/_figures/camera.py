"""Initial camera of a shape in a figure, by its view: rows to the right, up, and to the viewer."""

from typing import Any, Final

import numpy as np

from isomatch._figures.colors import Floats

_DISTANCE: Final = 1.3
"""Distance of the camera, in sides of the cube that the shape fills."""


def aligned_view(view: Floats, other: Floats, points: Floats, other_points: Floats) -> Floats:
    """Return the view of another shape that shows corresponding points as a view does.

    The least-squares rotation about the vertical is applied. Shapes with different verticals, or
    with fewer than three corresponding points, keep their `other` view.

    Parameters
    ----------
    view, other
        (3, 3) views of both shapes by themselves.
    points, other_points
        (n, 3) corresponding points on both shapes.
    """
    right, up, towards = view
    if not np.allclose(up, other[1]) or len(points) < 3:
        return other
    here, there = (
        flat - flat.mean()
        for flat in (each @ right + 1j * (each @ towards) for each in (points, other_points))
    )
    angle = np.angle(np.vdot(there, here))
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.stack([cosine * right - sine * towards, up, sine * right + cosine * towards])


def camera_of(view: Floats) -> dict[str, Any]:
    """Return plotly's ``layout.scene.camera`` of a view."""
    return {
        name: dict(zip("xyz", direction.tolist(), strict=True))
        for name, direction in (("up", view[1]), ("eye", _DISTANCE * view[2]))
    }
