"""Initial camera of a shape in a figure, by its view: rows to the right, up, and to the viewer."""

from typing import Any, Final

import numpy as np

from isomatch._figures.colors import Floats

_DISTANCE: Final = 1.3
"""Distance of the camera, in sides of the cube that the shape fills."""

_TILT: Final = 2.0
"""Factor by which squared distances must fall for a target to be tilted, as in pictures."""

_ROUNDING: Final = 1e-9
"""Squared distances, of points of unit spread, that are aligned."""


def aligned_view(view: Floats, points: Floats, other_points: Floats) -> Floats:
    """Return the view of a target in which its matched points are nearest to those of the source.

    As in the service's pictures, the target is rotated about the vertical, unless a rotation about
    another axis brings its points much nearer, as where files have different axes up. With fewer
    than three points it is not rotated.

    Parameters
    ----------
    view
        (3, 3) view of the source.
    points, other_points
        (n, 3) corresponding points of source and target.

    Returns
    -------
    (3, 3) rows: right, up, and towards the reader.
    """
    if len(points) < 3:
        return view
    seen, other = (_of_unit_spread(each @ view.T) for each in (points, other_points))
    turn = np.angle(np.vdot(other[:, 0] + 1j * other[:, 2], seen[:, 0] + 1j * seen[:, 2]))
    cosine, sine = np.cos(turn), np.sin(turn)
    upright = np.array([[cosine, 0.0, -sine], [0.0, 1.0, 0.0], [sine, 0.0, cosine]])
    free = _nearest_rotation(seen, other)
    apart, least = (float(((other @ each.T - seen) ** 2).sum()) for each in (upright, free))
    turned: Floats = (free if apart > _TILT * least + _ROUNDING else upright) @ view
    return turned


def _nearest_rotation(seen: Floats, other: Floats) -> Floats:
    """Return the rotation that brings centred points nearest to others (Kabsch, 1976)."""
    left, _, right = np.linalg.svd(seen.T @ other)
    left[:, 2] *= np.sign(np.linalg.det(left @ right))
    rotation: Floats = left @ right
    return rotation


def _of_unit_spread(points: Floats) -> Floats:
    centred = points - points.mean(axis=0)
    spread: Floats = centred / max(float(centred.std()), 1e-300)
    return spread


def camera_of(view: Floats) -> dict[str, Any]:
    """Return plotly's ``layout.scene.camera`` of a view."""
    return {
        name: dict(zip("xyz", direction.tolist(), strict=True))
        for name, direction in (("up", view[1]), ("eye", _DISTANCE * view[2]))
    }
