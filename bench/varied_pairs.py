"""A broad mix of pairs with known truth, easy and hard ones, of which many answers are wrong.

People of many proportions in random poses, gorillas, quadrupeds and centaurs of many kinds, limbs
that differ between left and right, holes, glue, noise, few and many vertices; and pairs of
different classes, of which no answer is right.
"""

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import KDTree

from bench.collection import KnownShape
from bench.humans import UNUSUAL, USUAL, random_pose, random_proportions
from bench.quadrupeds import mixture
from solver.arrays import FloatArray, IntArray
from solver.mesh import TriangleMesh, triangle_mesh
from solver.registration.surface import MIRROR
from solver.shape import Shape
from synthetic import (
    Pose,
    SyntheticShape,
    Transformed,
    glued,
    human_figure,
    near_in_space,
    noisy,
    transferred,
    with_holes,
)
from synthetic.animal_poses import CENTAUR_POSES, GORILLA_POSES, QUADRUPED_POSES
from synthetic.centaur import centaur_figure
from synthetic.classes import GORILLA
from synthetic.quadruped import QuadrupedProportions, quadruped_figure
from synthetic.shapes import posed
from synthetic.skeleton import Figure

AS_IT_IS = "as it is"
DIFFERENT = "different classes"
LOPSIDED = "lopsided people"

USUAL_VERTICES, COARSE_VERTICES, FINE_VERTICES = (1500, 4000), (600, 1200), (7000, 10_000)
"""Ranges of the numbers of vertices."""

_CHANGED = 0.6
"""Share of the pairs whose target is changed."""
_BENT = 0.5, 1.2
"""Range of the factors on the angles of named poses."""
_KINDS_SPREAD = 0.35
"""Greatest change of the logarithm of a measure of a quadruped or gorilla."""
_ASYMMETRY, _NEAR_SYMMETRY = (0.15, 0.35), (0.02, 0.08)
"""Ranges of the absolute logarithm of a left limb's size against the right one's."""
_NOISE_EDGES = 0.1, 0.4
"""Range of the standard deviation of noise along the normals, in mean lengths of edges."""
_GLUE_APART, _GLUE_RADIUS = 0.6, 0.02
"""Least geodesic distance of what is glued, and radius of the discs, over √area."""
_HOLE_RADIUS = 0.03, 0.06
_MOST_HOLES = 5


@dataclass(frozen=True, eq=False)
class Body:
    """A figure in a pose; `symmetric` if the figure is its own mirror image."""

    figure: Figure
    pose: Pose
    symmetric: bool = True


@dataclass(frozen=True, eq=False)
class VariedPair:
    """Two shapes to be matched.

    Parameters
    ----------
    kind
        One of `KINDS`.
    condition
        One of `CONDITIONS`: what was done to the target.
    source, target
        Without truth if they are of different classes.
    """

    kind: str
    condition: str
    source: KnownShape
    target: KnownShape


def varied_pair(number: int, seed: int = 0, condition: str | None = None) -> VariedPair:
    """Generate a pair: the same for the same numbers.

    Parameters
    ----------
    number
        Kinds take turns.
    seed
        Of all that is drawn.
    condition
        One of `CONDITIONS`; drawn if not given.
    """
    rng = np.random.default_rng([seed, number])
    kind = list(KINDS)[number % len(KINDS)]
    if condition is None:
        changed_too = rng.random() < _CHANGED
        condition = list(CONDITIONS)[int(rng.integers(1, len(CONDITIONS))) if changed_too else 0]
    source, target = KINDS[kind](rng)
    vertices = {"coarse": COARSE_VERTICES, "fine": FINE_VERTICES}.get(condition, USUAL_VERTICES)
    sizes = int(rng.integers(*USUAL_VERTICES)), int(rng.integers(*vertices))
    here, there = (
        posed(body.figure, body.pose, size, seed=place)
        for place, (body, size) in enumerate(zip((source, target), sizes, strict=True))
    )
    meshes = [_unit(one) for one in (here, there)]
    changed = CONDITIONS[condition](meshes[1], rng)
    if kind == DIFFERENT:
        unknown = [
            _known(f"{number}-{side}", mesh) for side, mesh in enumerate((meshes[0], changed.mesh))
        ]
        return VariedPair(kind, condition, unknown[0], unknown[1])
    truths = _truths(source, target, here, there)
    pair = _known_pair(str(number), meshes[0], changed, *truths)
    return VariedPair(kind, condition, *pair)


def _truths(
    source: Body, target: Body, here: SyntheticShape, there: SyntheticShape
) -> tuple[IntArray, IntArray | None]:
    """Vertices of the target for all of the source: direct, and mirrored if both are symmetric."""
    tree = KDTree(there.rest)

    def partners(places: FloatArray) -> IntArray:
        if source.figure != target.figure:
            places = transferred(places, source.figure, target.figure)
        return np.asarray(tree.query(places)[1], dtype=np.int64)

    if not (source.symmetric and target.symmetric):
        return partners(here.rest), None
    return partners(here.rest), partners(here.rest * MIRROR)


def _known_pair(
    name: str, mesh: TriangleMesh, changed: Transformed, truth: IntArray, mirrored: IntArray | None
) -> tuple[KnownShape, KnownShape]:
    """Both shapes, with the points whose partners are still there."""
    left = changed.kept[truth]
    here = np.flatnonzero(left)
    symmetric = None if mirrored is None else changed.image[mirrored[left]]
    target = _known(f"{name}-1", changed.mesh)
    return (
        replace(_known(f"{name}-0", mesh), truth=here),
        replace(target, truth=changed.image[truth[left]], symmetric_truth=symmetric),
    )


def _known(name: str, mesh: TriangleMesh) -> KnownShape:
    return KnownShape(name, name, Shape(mesh), None, None)


def _unit(shape: SyntheticShape) -> TriangleMesh:
    mesh = triangle_mesh(shape.vertices, shape.faces)
    return mesh.scaled(1.0 / np.sqrt(mesh.area))


def _bent(poses: Mapping[str, Pose], rng: np.random.Generator) -> Pose:
    """One of the poses, every angle changed, mirrored or not."""
    turns = list(poses.values())[int(rng.integers(len(poses)))].turns
    pose = Pose(
        tuple(
            (name, (x * rng.uniform(*_BENT), y * rng.uniform(*_BENT), z * rng.uniform(*_BENT)))
            for name, (x, y, z) in turns
        )
    )
    return pose.mirrored() if rng.random() < 0.5 else pose


def _person(rng: np.random.Generator) -> Body:
    return Body(human_figure(random_proportions(USUAL, rng)), random_pose(rng))


def _unusual_person(rng: np.random.Generator) -> Body:
    return Body(human_figure(random_proportions(UNUSUAL, rng)), random_pose(rng))


def _gorilla(rng: np.random.Generator) -> Body:
    spans = {name: (0.85 * value, value / 0.85) for name, value in vars(GORILLA).items()}
    varied = random_proportions({name: spans[name] for name in USUAL}, rng)
    return Body(human_figure(varied), _bent(GORILLA_POSES, rng))


def _quadruped_proportions(rng: np.random.Generator) -> QuadrupedProportions:
    shares = rng.dirichlet(np.full(3, 0.4))
    return mixture(shares, rng.uniform(0.0, _KINDS_SPREAD), rng)


def _quadruped(rng: np.random.Generator) -> Body:
    return Body(quadruped_figure(_quadruped_proportions(rng)), _bent(QUADRUPED_POSES, rng))


def _centaur(rng: np.random.Generator) -> Body:
    figure = centaur_figure(_quadruped_proportions(rng), random_proportions(USUAL, rng))
    return Body(figure, _bent(CENTAUR_POSES, rng))


_ANY: tuple[Callable[[np.random.Generator], Body], ...] = _person, _gorilla, _quadruped, _centaur


def _one_individual(rng: np.random.Generator) -> tuple[Body, Body]:
    draw = _ANY[int(rng.integers(len(_ANY)))]
    one = draw(rng)
    return one, replace(one, pose=draw(rng).pose)


def _different(rng: np.random.Generator) -> tuple[Body, Body]:
    upright = _person if rng.random() < 0.5 else _gorilla
    draws = [upright, _quadruped, _centaur]
    first, second = rng.permutation(len(draws))[:2]
    return draws[first](rng), draws[second](rng)


def _lopsided(span: tuple[float, float]) -> Callable[[np.random.Generator], tuple[Body, Body]]:
    """Two people whose left limbs differ from the right ones, both alike."""

    def draw(rng: np.random.Generator) -> tuple[Body, Body]:
        sizes = np.exp(rng.choice([-1.0, 1.0], 3) * rng.uniform(*span, 3))
        limbs = dict(zip(("left_arm", "left_leg", "left_hand"), sizes.tolist(), strict=True))
        one, other = (
            Body(
                human_figure(replace(random_proportions(USUAL, rng), **limbs)),
                random_pose(rng),
                symmetric=False,
            )
            for _ in range(2)
        )
        return one, other

    return draw


KINDS: Mapping[str, Callable[[np.random.Generator], tuple[Body, Body]]] = {
    "one individual": _one_individual,
    "people": lambda rng: (_person(rng), _person(rng)),
    "people, unusual": lambda rng: (_person(rng), _unusual_person(rng)),
    "gorilla and person": lambda rng: (_gorilla(rng), _person(rng)),
    "quadrupeds": lambda rng: (_quadruped(rng), _quadruped(rng)),
    "centaurs": lambda rng: (_centaur(rng), _centaur(rng)),
    LOPSIDED: _lopsided(_ASYMMETRY),
    "nearly symmetric people": _lopsided(_NEAR_SYMMETRY),
    DIFFERENT: _different,
}
"""What a pair shows, as a function that draws two bodies."""


def _as_it_is(mesh: TriangleMesh, rng: np.random.Generator) -> Transformed:
    every = np.arange(mesh.n_vertices)
    return Transformed(mesh, every, np.ones(mesh.n_vertices, dtype=np.bool_))


def _noisy(mesh: TriangleMesh, rng: np.random.Generator) -> Transformed:
    return noisy(mesh, rng.uniform(*_NOISE_EDGES), seed=int(rng.integers(1 << 30)))


def _glued(mesh: TriangleMesh, rng: np.random.Generator) -> Transformed:
    """Glued by tubes, or at single triangles where a limb is thinner than the disc."""
    places = near_in_space(mesh, int(rng.integers(1, 3)), _GLUE_APART)
    for radius in (_GLUE_RADIUS, None):
        with suppress(ValueError):
            return glued(mesh, places, radius)
    return _as_it_is(mesh, rng)


def _with_holes(mesh: TriangleMesh, rng: np.random.Generator) -> Transformed:
    """With holes, unless the body is too thin for them."""
    count, radius = int(rng.integers(1, _MOST_HOLES + 1)), rng.uniform(*_HOLE_RADIUS)
    with suppress(ValueError):
        return with_holes(mesh, count, radius, int(rng.integers(1 << 30)))
    return _as_it_is(mesh, rng)


CONDITIONS: Mapping[str, Callable[[TriangleMesh, np.random.Generator], Transformed]] = {
    AS_IT_IS: _as_it_is,
    "noise": _noisy,
    "glued": _glued,
    "holes": _with_holes,
    "coarse": _as_it_is,
    "fine": _as_it_is,
}
"""What was done to the target; coarse and fine ones have other numbers of vertices."""
