"""Four-legged animals, mixtures of cat, dog and horse, in several poses, with the truth."""

from collections.abc import Mapping
from dataclasses import fields

import numpy as np
from scipy.spatial import KDTree

from bench.humans import Family, Unfamiliar
from bench.symmetry import mirrored_vertices
from solver.arrays import FloatArray, IntArray
from solver.mesh import triangle_mesh
from solver.shape import Shape
from synthetic import Pose, transferred
from synthetic.animal_poses import QUADRUPED_POSES
from synthetic.pose import Deformation
from synthetic.quadruped import CAT, DOG, HORSE, QuadrupedProportions, quadruped_figure
from synthetic.shapes import posed
from synthetic.surface import skin

KINDS: Mapping[str, QuadrupedProportions] = {"cat": CAT, "dog": DOG, "horse": HORSE}

FAMILY_SPREAD = 0.15
"""Greatest change of the logarithm of a measure of the family's animals."""

SPREADS = 0.1, 0.35
"""The same of individuals, by turns: within what the family shows, and outside of it."""

_RESOLUTION = 2000
_ANIMAL_RESOLUTION = 2500


def quadruped_family(count: int, seed: int = 11) -> Family:
    """Return a standard quadruped and `count` mixtures of the three kinds, in random poses."""
    standard, rng = quadruped_figure(QuadrupedProportions()), np.random.default_rng(seed)
    rest, faces = skin(standard, _RESOLUTION, 0)
    poses = list(QUADRUPED_POSES.values())
    examples = []
    for _ in range(count):
        proportions = mixture(rng.dirichlet(np.ones(len(KINDS))), FAMILY_SPREAD, rng)
        figure = quadruped_figure(proportions)
        deformation = Deformation(figure, transferred(rest, standard, figure), faces)
        pose = poses[int(rng.integers(len(poses)))]
        examples.append(Shape(triangle_mesh(deformation(pose), faces)))
    reference = Deformation(standard, rest, faces)(Pose())
    return Family(Shape(triangle_mesh(reference, faces)), examples, rest, mirrored_vertices(rest))


def individuals(family: Family, count: int, seed: int) -> list[tuple[str, Unfamiliar]]:
    """Return animals of the kinds by turns, each triangulated on its own, in random poses."""
    standard, rng = quadruped_figure(QuadrupedProportions()), np.random.default_rng(seed)
    poses = list(QUADRUPED_POSES.values())
    animals = []
    for number in range(count):
        place = number % len(KINDS)
        spread = SPREADS[number // len(KINDS) % len(SPREADS)]
        proportions = mixture(np.eye(len(KINDS))[place], spread, rng)
        figure = quadruped_figure(proportions)
        pose = poses[int(rng.integers(len(poses)))]
        animal = posed(figure, pose, _ANIMAL_RESOLUTION, seed + number)
        truth: IntArray = np.asarray(
            KDTree(animal.rest).query(transferred(family.rest, standard, figure))[1], dtype=np.int64
        )
        shape = Shape(triangle_mesh(animal.vertices, animal.faces))
        animals.append((list(KINDS)[place], Unfamiliar(shape, truth)))
    return animals


def mixture(shares: FloatArray, spread: float, rng: np.random.Generator) -> QuadrupedProportions:
    """Proportions between those of the kinds, each measure changed by up to a factor e^spread.

    Parameters
    ----------
    shares
        (3,) of the kinds, summing to 1.
    spread
        Greatest change of a measure's logarithm; angles are not changed.
    rng
        Of the changes.
    """
    values = {}
    for field in fields(QuadrupedProportions):
        mean = sum(
            share * getattr(kind, field.name)
            for share, kind in zip(shares, KINDS.values(), strict=True)
        )
        angle = field.name.endswith(("rise", "drop"))
        values[field.name] = float(mean if angle else mean * np.exp(rng.uniform(-spread, spread)))
    return QuadrupedProportions(**values)
