"""Remarks on landmarks that do not lie on the surface of their template."""

from typing import Final

import numpy as np
import numpy.typing as npt

from isomatch._landmarks.confidence import square_root_of_area
from isomatch._landmarks.landmark_set import LandmarkSet
from isomatch._landmarks.surface_points import nearest_points
from isomatch._results import Geometry

Floats = npt.NDArray[np.float64]

FAR: Final = 0.05
"""Distance from the surface, over √area, above which a landmark is reported and not carried."""


def remarks_on(landmarks: LandmarkSet, template: Geometry) -> tuple[str, ...]:
    """Report landmarks that are far from the surface of their template.

    Parameters
    ----------
    landmarks
        Of the template.
    template
        Its surface.

    Returns
    -------
    Sentences; none if all landmarks are within `FAR` √area of the surface.

    Raises
    ------
    ValueError
        No landmark is, so that none can be carried.
    """
    given = landmarks.positions[landmarks.present]
    if not len(given):
        raise ValueError("all landmarks are missing")
    size = square_root_of_area(template)
    apart = _distances(template, given) / size
    far = apart > FAR
    if not far.any():
        return ()
    worst = int(apart.argmax())
    label = landmarks.labels[np.flatnonzero(landmarks.present)[worst]]
    text = (
        f"{int(far.sum())} of {len(given)} landmarks are far from the surface, {label!r} by"
        f" {apart[worst] * size:.4g}"
    )
    none = ": check the unit of length and the coordinate system (LPS or RAS)"
    text += none if far.all() else "; they are left out"
    turned = _distances(template, given * np.array([-1.0, -1.0, 1.0])) / size
    if np.median(turned) < 0.5 * np.median(apart):
        text += ". With x and y negated they are nearer: is the mesh in RAS coordinates?"
    if far.all():
        raise ValueError(text)
    return (text,)


def _distances(geometry: Geometry, positions: Floats) -> Floats:
    nearest = nearest_points(geometry, positions).positions(geometry)
    found: Floats = np.linalg.norm(positions - nearest, axis=1)
    return found
