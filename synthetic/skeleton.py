"""A figure: joints that turn, and rounded cones of flesh that follow them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from solver.arrays import FloatArray, IntArray

Point = tuple[float, float, float]
"""x (to the figure's left), y (up), z (to its front), in metres."""


@dataclass(frozen=True)
class Joint:
    """A point that everything behind it in the tree turns about.

    ``parent`` names the joint that carries this one; the root has none. Parents come before
    their children in a figure.
    """

    name: str
    parent: str | None
    position: Point


@dataclass(frozen=True)
class Flesh:
    """A rounded cone: the balls of linearly growing radius between two ends.

    It turns rigidly with the joint called ``joint``.
    """

    joint: str
    start: Point
    start_radius: float
    end: Point
    end_radius: float


@dataclass(frozen=True)
class Cones:
    """The flesh of a figure as arrays, n cones.

    Attributes
    ----------
    start, end
        (n, 3) float64, the ends of the axes.
    start_radius, end_radius
        (n,) float64.
    joint
        (n,) int64, index of the joint that each cone follows.
    """

    start: FloatArray
    end: FloatArray
    start_radius: FloatArray
    end_radius: FloatArray
    joint: IntArray


@dataclass(frozen=True)
class Figure:
    """An articulated figure in its rest pose.

    Attributes
    ----------
    joints
        Parents before children.
    flesh
        The cones whose smooth union is the body. Two figures of one kind list the same cones in
        the same order, whatever their proportions: that is what makes their points correspond.
    blend
        Width of the smooth union, in metres.
    landmarks
        Named points of the body, each near its surface.
    """

    joints: tuple[Joint, ...]
    flesh: tuple[Flesh, ...]
    blend: float
    landmarks: tuple[tuple[str, Point], ...]

    def joint_index(self) -> dict[str, int]:
        """Position of every joint in ``joints``, by name."""
        return {joint.name: index for index, joint in enumerate(self.joints)}

    def cones(self) -> Cones:
        """The flesh as arrays."""
        index = self.joint_index()
        return Cones(
            start=np.array([cone.start for cone in self.flesh], dtype=np.float64),
            end=np.array([cone.end for cone in self.flesh], dtype=np.float64),
            start_radius=np.array([cone.start_radius for cone in self.flesh], dtype=np.float64),
            end_radius=np.array([cone.end_radius for cone in self.flesh], dtype=np.float64),
            joint=np.array([index[cone.joint] for cone in self.flesh], dtype=np.int64),
        )


def mirror_image(
    joints: Sequence[Joint], flesh: Sequence[Flesh]
) -> tuple[list[Joint], list[Flesh]]:
    """Reflect a left limb in the plane x = 0, and call it right.

    Parameters
    ----------
    joints, flesh
        Parts whose joints are called ``left_...``.

    Returns
    -------
    joints, flesh
        The same parts on the other side, called ``right_...``.
    """
    return (
        [
            Joint(
                other_side(joint.name),
                joint.parent and other_side(joint.parent),
                _mirrored(joint.position),
            )
            for joint in joints
        ],
        [
            replace(
                cone,
                joint=other_side(cone.joint),
                start=_mirrored(cone.start),
                end=_mirrored(cone.end),
            )
            for cone in flesh
        ],
    )


def other_side(name: str) -> str:
    """Name of the part that is the mirror image of the one called ``name``."""
    if name.startswith("left_"):
        return "right_" + name.removeprefix("left_")
    if name.startswith("right_"):
        return "left_" + name.removeprefix("right_")
    return name


def _mirrored(point: Point) -> Point:
    return (-point[0], point[1], point[2])
