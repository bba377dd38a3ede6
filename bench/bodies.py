"""Human bodies on which prototypes are evaluated, with the truth of their points."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import KDTree

from bench.collection import KnownShape
from bench.figure6 import RIGHT
from bench.humans import Family
from bench.quadrupeds import individuals
from solver.arrays import IntArray
from solver.mesh import TriangleMesh, triangle_mesh
from solver.prototype import Prototype, match_prototype
from solver.shape import Shape
from synthetic import HUMAN_POSES, HumanProportions, Pose, human, human_figure, transferred

_SEED = 3002
_RESOLUTION = 3000

POSES: Mapping[str, Pose] = {
    "T-pose": HUMAN_POSES["rest"],
    "A-pose": HUMAN_POSES["standing"],
    "walking": HUMAN_POSES["walking"],
    "sitting": HUMAN_POSES["sitting"],
    "arms crossed": Pose(
        (
            ("left_shoulder", (0.0, -60.0, -35.0)),
            ("right_shoulder", (0.0, 60.0, 35.0)),
            ("left_elbow", (-25.0, -85.0, 0.0)),
            ("right_elbow", (-45.0, 85.0, 0.0)),
        )
    ),
    "kneeling": Pose(
        (
            ("left_shoulder", (-20.0, 0.0, -40.0)),
            ("right_shoulder", (-20.0, 0.0, 40.0)),
            ("left_hip", (-70.0, 0.0, 6.0)),
            ("left_knee", (110.0, 0.0, 0.0)),
            ("right_hip", (5.0, 0.0, -3.0)),
            ("right_knee", (115.0, 0.0, 0.0)),
        )
    ),
}

PROPORTIONS: Mapping[str, HumanProportions] = {
    "child": HumanProportions(head=1.6, arm=0.8, leg=0.7, torso=0.85, shoulders=0.85, limbs=1.1),
    "giant": HumanProportions(head=0.7, arm=1.2, leg=1.3, torso=1.15, girth=1.25, limbs=1.25),
    "stout": HumanProportions(girth=1.7, limbs=1.5, leg=0.9, arm=0.9),
    "thin": HumanProportions(girth=0.6, limbs=0.55, arm=1.1, leg=1.15),
    "one arm long, one leg short": HumanProportions(left_arm=1.3, left_leg=0.8, left_hand=1.5),
}


@dataclass(frozen=True, eq=False)
class Body:
    """A body before it is scanned.

    Attributes
    ----------
    name
        What the table calls it.
    clean
        Its surface, of unit area.
    truth, mirrored
        (N,) vertices of it at the prototype's points, and at their mirror images.
    """

    name: str
    clean: Shape
    truth: IntArray
    mirrored: IntArray


def unit(mesh: TriangleMesh) -> TriangleMesh:
    """The same surface, of unit area."""
    return replace(mesh, vertices=mesh.vertices / np.sqrt(mesh.area))


def generated_humans(prototype: Prototype, family: Family) -> list[Body]:
    """Humans in poses and of proportions that nobody learned from."""
    standard = human_figure(HumanProportions())
    known = {name: (HumanProportions(), pose) for name, pose in POSES.items()}
    known |= {name: (one, HUMAN_POSES["standing"]) for name, one in PROPORTIONS.items()}
    bodies = []
    for number, (name, (proportions, pose)) in enumerate(known.items()):
        figure = human(pose, proportions, _RESOLUTION, seed=_SEED + number)
        places = transferred(family.rest, standard, human_figure(proportions))
        truth = np.asarray(KDTree(figure.rest).query(places)[1], dtype=np.int64)
        shape = Shape(unit(triangle_mesh(figure.vertices, figure.faces)))
        points = prototype.vertices
        bodies.append(Body(name, shape, truth[points], truth[family.mirrored[points]]))
    return bodies


def generated_animals(prototype: Prototype, family: Family) -> list[Body]:
    """One cat, dog and horse each, within and outside of what the family shows."""
    points, bodies = prototype.vertices, []
    for number, (kind, animal) in enumerate(individuals(family, 6, _SEED)):
        shape = Shape(unit(animal.shape.mesh))
        name = f"{kind}{', unusual' if number >= 3 else ''}"
        truth, mirrored = animal.truth[points], animal.truth[family.mirrored[points]]
        bodies.append(Body(name, shape, truth, mirrored))
    return bodies


def real_bodies(prototype: Prototype, poses: Sequence[KnownShape]) -> list[Body]:
    """All poses of a real body, with the prototype's points where most answers put them.

    Nobody has said where the points are in truth. Of the answers for the clean poses that one
    counts which agrees with most others; it should be looked at.
    """
    shapes = [Shape(unit(pose.shape.mesh)) for pose in poses]
    places = []
    for pose, shape in zip(poses, shapes, strict=True):
        assert pose.truth is not None
        found = match_prototype(prototype, shape).best
        there = found.target[np.argsort(found.source)]
        places.append(shape.metric("geodesic").distances(there)[:, pose.truth].argmin(axis=1))
    first, truth = poses[0], poses[0].truth
    assert truth is not None
    between = shapes[0].metric("geodesic").between(truth)
    agreeing = [sum((between[a, b] < RIGHT).all() for b in places) for a in places]
    print(f"{first.category}: {max(agreeing)} of {len(poses)} clean poses agree", flush=True)
    chosen = places[int(np.argmax(agreeing))]
    bodies = []
    for pose, shape in zip(poses, shapes, strict=True):
        assert pose.truth is not None
        assert pose.symmetric_truth is not None
        bodies.append(Body(pose.name, shape, pose.truth[chosen], pose.symmetric_truth[chosen]))
    return bodies
