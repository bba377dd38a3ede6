"""Ground truth between bodies of one kind and different proportions."""

from functools import partial

import numpy as np
from scipy.spatial.transform import Rotation

from solver.arrays import FloatArray
from synthetic.implicit import body, cone_distances
from synthetic.remeshing import onto
from synthetic.skeleton import Cones, Figure

_WIDTH = 0.025
"""Distance over which a point's weight passes from one cone of flesh to the next, in metres."""


def transferred(points: FloatArray, source: Figure, target: Figure) -> FloatArray:
    """Transfer points to a body of other proportions.

    Every cone of flesh carries the points near it: at the same fraction of its length, in the same
    direction from its axis, at a distance proportional to its radius.

    Parameters
    ----------
    points
        (p, 3) float64, on the skin of the source at rest.
    source, target
        Figures of one kind: the same cones in the same order.

    Returns
    -------
    images
        (p, 3) float64, on the skin of the target at rest.

    Raises
    ------
    ValueError
        The figures are of different kinds.
    """
    if [cone.joint for cone in source.flesh] != [cone.joint for cone in target.flesh]:
        raise ValueError("figures of different kinds have no correspondence")
    here, there = source.cones(), target.cones()
    distances = cone_distances(here, points)
    shares = np.exp((distances.min(axis=1, keepdims=True) - distances) / _WIDTH)
    shares /= shares.sum(axis=1, keepdims=True)
    images = np.zeros_like(points)
    for i in range(len(source.flesh)):
        near = shares[:, i] > 1e-9
        images[near] += shares[near, i, None] * _along_cone(points[near], here, there, i)
    surface = partial(body, there, target.blend)
    for _ in range(4):
        images = onto(images, surface)
    return images


def _along_cone(points: FloatArray, here: Cones, there: Cones, i: int) -> FloatArray:
    """Points moved as the i-th cone is."""
    axis, new_axis = here.end[i] - here.start[i], there.end[i] - there.start[i]
    from_start = points - here.start[i]
    along = np.clip(from_start @ axis / max(float(axis @ axis), 1e-30), 0.0, 1.0)[:, None]
    radius = here.start_radius[i] + along * (here.end_radius[i] - here.start_radius[i])
    new_radius = there.start_radius[i] + along * (there.end_radius[i] - there.start_radius[i])
    aside = (from_start - along * axis) @ _shortest_turn(axis, new_axis).T
    images: FloatArray = there.start[i] + along * new_axis + aside * new_radius / radius
    return images


def _shortest_turn(axis: FloatArray, other: FloatArray) -> FloatArray:
    """Rotation matrix that takes the direction of one vector to that of another."""
    across = np.cross(axis, other)
    sine = float(np.linalg.norm(across))
    if sine < 1e-12:
        return np.eye(3)
    angle = np.arctan2(sine, float(axis @ other))
    turn: FloatArray = Rotation.from_rotvec(across * (angle / sine)).as_matrix()
    return turn
