"""Humans of many proportions in many poses, and figures outside of these, with the truth."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from bench.symmetry import mirrored_vertices
from solver.arrays import FloatArray, IntArray
from solver.mesh import triangle_mesh
from solver.shape import Shape
from synthetic import HumanProportions, Pose, human, human_figure, transferred
from synthetic.pose import Deformation

USUAL = {
    "head": (0.75, 1.5),
    "arm": (0.75, 1.3),
    "leg": (0.7, 1.25),
    "torso": (0.85, 1.15),
    "shoulders": (0.85, 1.2),
    "girth": (0.8, 1.25),
    "limbs": (0.75, 1.25),
}
"""Ranges of the family's proportions."""

UNUSUAL = {
    "head": (1.6, 2.4),
    "arm": (1.25, 1.6),
    "leg": (0.55, 0.8),
    "torso": (0.75, 1.0),
    "shoulders": (0.75, 1.0),
    "girth": (0.55, 0.85),
    "limbs": (0.55, 0.85),
}
"""Those of alien-like figures: great heads, long arms and short legs on thin bodies. No head, and
hardly an arm or a leg, is like any in the family."""

_RESOLUTION = 2000
_FIGURE_RESOLUTION = 2500


@dataclass(frozen=True, eq=False)
class Family:
    """Figures of one kind, triangulated alike: vertex i of one is vertex i of all.

    Attributes
    ----------
    reference
        The standard figure, standing.
    examples
        Others, of the family's proportions in random poses.
    rest
        (V, 3) vertices of the standard figure at rest.
    mirrored
        (V,) each vertex's mirror image.
    """

    reference: Shape
    examples: list[Shape]
    rest: FloatArray
    mirrored: IntArray


@dataclass(frozen=True, eq=False)
class Unfamiliar:
    """A figure triangulated on its own.

    Attributes
    ----------
    shape
        The figure.
    truth
        (V,) its vertex at the place of each vertex of the family.
    """

    shape: Shape
    truth: IntArray


def random_proportions(
    ranges: dict[str, tuple[float, float]], rng: np.random.Generator
) -> HumanProportions:
    """Proportions whose logarithms are spread evenly."""
    return HumanProportions(
        **{name: float(np.exp(rng.uniform(*np.log(span)))) for name, span in ranges.items()}
    )


def random_pose(rng: np.random.Generator) -> Pose:
    """A pose with every joint somewhere in its range."""

    def within(least: float, most: float) -> float:
        return float(rng.uniform(least, most))

    turns = [
        ("spine", (within(-10, 20), within(-15, 15), within(-10, 10))),
        ("chest", (within(-8, 12), within(-15, 15), within(-10, 10))),
        ("head", (within(-20, 20), within(-35, 35), within(-12, 12))),
    ]
    for side, sign in (("left", 1.0), ("right", -1.0)):
        shoulder = within(-70, 40), sign * within(-20, 20), sign * within(-45, 70)
        hip = within(-80, 25), sign * within(-15, 15), sign * within(-4, 25)
        turns += [
            (f"{side}_shoulder", shoulder),
            (f"{side}_elbow", (within(-40, 0), -sign * within(0, 80), 0.0)),
            (f"{side}_hip", hip),
            (f"{side}_knee", (within(0, 90), 0.0, 0.0)),
            (f"{side}_ankle", (within(-15, 15), 0.0, 0.0)),
        ]
    return Pose(tuple(turns))


def human_family(count: int, seed: int = 1) -> Family:
    """Return the standard human and `count` examples of the family."""
    standing = human("standing", resolution=_RESOLUTION)
    standard, rng = human_figure(HumanProportions()), np.random.default_rng(seed)
    examples = []
    for _ in range(count):
        figure = human_figure(random_proportions(USUAL, rng))
        rest = transferred(standing.rest, standard, figure)
        vertices = Deformation(figure, rest, standing.faces)(random_pose(rng))
        examples.append(Shape(triangle_mesh(vertices, standing.faces)))
    reference = Shape(triangle_mesh(standing.vertices, standing.faces))
    return Family(reference, examples, standing.rest, mirrored_vertices(standing.rest))


def unfamiliar_figures(family: Family, count: int, seed: int = 2) -> list[Unfamiliar]:
    """Return figures outside of the family, in random poses."""
    standard, rng = human_figure(HumanProportions()), np.random.default_rng(seed)
    figures = []
    for number in range(count):
        proportions = random_proportions(UNUSUAL, rng)
        figure = human(random_pose(rng), proportions, _FIGURE_RESOLUTION, seed=number)
        places = transferred(family.rest, standard, human_figure(proportions))
        truth = np.asarray(KDTree(figure.rest).query(places)[1], dtype=np.int64)
        figures.append(Unfamiliar(Shape(triangle_mesh(figure.vertices, figure.faces)), truth))
    return figures
