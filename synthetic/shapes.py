"""Posed figures, and the true correspondence between any two poses of one."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.spatial import KDTree

from solver.arrays import FloatArray, IntArray
from synthetic.classes import CLASSES
from synthetic.human import HumanProportions, human_figure
from synthetic.pose import Deformation, Pose
from synthetic.repertoire import HUMAN_POSES
from synthetic.skeleton import Figure
from synthetic.surface import skin


@dataclass(frozen=True, eq=False)
class SyntheticShape:
    """A posed surface, and the rest position of each of its vertices.

    Attributes
    ----------
    vertices, faces
        (V, 3) float64, in metres, y up, and (F, 3) int64: closed, of genus 0, one component,
        oriented outwards.
    rest
        (V, 3) float64, the same vertices in the rest pose: points of two poses of one figure
        correspond where these agree.
    """

    vertices: FloatArray
    faces: IntArray
    rest: FloatArray


def human(
    pose: str | Pose = "standing",
    proportions: HumanProportions | None = None,
    resolution: int = 3000,
    seed: int = 0,
) -> SyntheticShape:
    """A human body.

    Parameters
    ----------
    pose
        A name in :data:`HUMAN_POSES`, or a pose.
    proportions
        Of the body; the standard one if not given.
    resolution
        Number of vertices, 200 or more.
    seed
        Of the triangulation. Shapes of equal proportions, resolution and seed have the same
        triangulation: vertex i of one corresponds to vertex i of the other.

    Returns
    -------
    shape
        The posed surface.
    """
    figure = _human_figure(proportions or HumanProportions())
    return posed(figure, HUMAN_POSES[pose] if isinstance(pose, str) else pose, resolution, seed)


def articulated(
    category: str, pose: str | Pose, resolution: int = 3000, seed: int = 0
) -> SyntheticShape:
    """A shape of one of the classes.

    Parameters
    ----------
    category
        A name in :data:`CLASSES`.
    pose
        The name of one of the class's poses, or a pose.
    resolution
        Number of vertices, 200 or more.
    seed
        Of the triangulation, as for :func:`human`.

    Returns
    -------
    shape
        The posed surface.
    """
    known = CLASSES[category]
    turns = known.poses[pose] if isinstance(pose, str) else pose
    return posed(known.figure, turns, resolution, seed)


def posed(figure: Figure, pose: Pose, resolution: int, seed: int) -> SyntheticShape:
    """A figure in a pose.

    Parameters
    ----------
    figure
        The figure.
    pose
        The turns of its joints.
    resolution, seed
        Of the triangulation: figures in several poses share it if these are equal.

    Returns
    -------
    shape
        The posed surface.
    """
    rest, faces, deformation = _at_rest(figure, resolution, seed)
    vertices = deformation(pose)
    vertices.setflags(write=False)
    return SyntheticShape(vertices, faces, rest)


@lru_cache(maxsize=64)
def _human_figure(proportions: HumanProportions) -> Figure:
    return human_figure(proportions)


@lru_cache(maxsize=32)
def _at_rest(
    figure: Figure, resolution: int, seed: int
) -> tuple[FloatArray, IntArray, Deformation]:
    rest, faces = skin(figure, resolution, seed)
    rest.setflags(write=False)
    faces.setflags(write=False)
    return rest, faces, Deformation(figure, rest, faces)


def correspondence(source: SyntheticShape, target: SyntheticShape) -> IntArray:
    """Ground truth: the target's vertex at (or nearest to) each vertex of the source.

    Parameters
    ----------
    source, target
        Shapes of one figure, in any poses and triangulations.

    Returns
    -------
    truth
        (V_source,) int64, vertices of the target.
    """
    nearest: IntArray = np.asarray(KDTree(target.rest).query(source.rest)[1], dtype=np.int64)
    return nearest
