"""Scans with components that are nothing of the shape: ``python -m bench.strays [--data DIR]``.

One shape of each pair is a scan: beside it is a ball, of a twenty-fifth or a fifth of its area, or
a floor below it, or debris; or its limbs are cut off and lie where they were, in components that
belong to it. Printed are the mean geodesic error of the direct dense map over √area, of points that
both shapes have; of how many of these one has no image; the probability that the answer is right,
and seconds, spectra included. Without ``--data``, the shapes are generated figures.
"""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
import trimesh

from bench.calibration import PROBABLY_RIGHT
from bench.collection import KnownShape, known_pairs, pair_options
from bench.command_line import command_line, parsed, print_json
from bench.dense import judged
from solver.arrays import FloatArray, IntArray
from solver.matching import MatchOptions
from solver.mesh import TriangleMesh, triangle_mesh
from solver.shape import Shape

_FLOOR = 24
"""Vertices along a side of the floor."""

_PATCHES, _PATCH_RADIUS, _THROWN = 8, 0.05, 0.2
"""Number of pieces of debris, their geodesic radius, and how far off they are, over √area."""

_LIMBS, _RING = 5, (0.3, 0.33)
"""Farthest samples, of which all but the first are ends of limbs, and the distances from these over
√area, between which limbs lose a ring."""

_LOST = 0.1
"""Share of the points of which one shape has no image, beyond which an answer is wrong."""

Condition = Callable[[Shape, np.random.Generator], TriangleMesh]
"""A scan of a shape, whose vertices come first and keep their numbers."""


def with_component(mesh: TriangleMesh, vertices: FloatArray, faces: IntArray) -> TriangleMesh:
    """Return a mesh with another component, whose vertices come last."""
    return triangle_mesh(
        np.concatenate([mesh.vertices, vertices]),
        np.concatenate([mesh.faces, faces + mesh.n_vertices]),
    )


def with_ball(mesh: TriangleMesh, share: float, direction: FloatArray) -> TriangleMesh:
    """Return a mesh with a ball beside it.

    Parameters
    ----------
    mesh
        The mesh.
    share
        Area of the ball over its own.
    direction
        (3,) in which the ball lies.
    """
    ball = trimesh.creation.icosphere(subdivisions=3)
    radius = np.sqrt(share * mesh.area / (4.0 * np.pi))
    way = direction / np.linalg.norm(direction)
    beyond = (mesh.vertices @ way).max() + 1.5 * radius
    middle = mesh.vertices.mean(axis=0)
    centre = middle + (beyond - middle @ way) * way
    return with_component(mesh, radius * ball.vertices + centre, ball.faces)


def with_floor(mesh: TriangleMesh, up: int) -> TriangleMesh:
    """Return a mesh with a square floor of half its area just below it.

    Parameters
    ----------
    mesh
        The mesh.
    up
        Axis of the vertical.
    """
    side = np.sqrt(0.5 * mesh.area)
    x, y = np.meshgrid(*(side * np.linspace(-0.5, 0.5, _FLOOR),) * 2, indexing="ij")
    numbers = np.arange(_FLOOR**2).reshape(_FLOOR, _FLOOR)
    a, b, c, d = (
        numbers[i : _FLOOR - 1 + i, j : _FLOOR - 1 + j].ravel()
        for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))
    )
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    flat = np.stack([np.zeros(x.size), x.ravel(), y.ravel()], axis=1)
    middle = mesh.vertices.mean(axis=0)
    middle[up] = mesh.vertices[:, up].min() - 0.02 * side
    return with_component(mesh, np.roll(flat, up, axis=1) + middle, faces)


def _ball(share: float) -> Condition:
    return lambda shape, rng: with_ball(shape.mesh, share, rng.standard_normal(3))


def _floor(shape: Shape, rng: np.random.Generator) -> TriangleMesh:
    return with_floor(shape.mesh, int(rng.integers(3)))


def _debris(shape: Shape, rng: np.random.Generator) -> TriangleMesh:
    found = shape.mesh
    seeds = rng.choice(shape.n_vertices, _PATCHES, replace=False)
    for distances in shape.metric("geodesic").distances(seeds) / shape.size:
        near = (distances < _PATCH_RADIUS)[shape.mesh.faces].all(axis=1)
        vertices, faces = np.unique(shape.mesh.faces[near], return_inverse=True)
        way = rng.standard_normal(3)
        thrown = _THROWN * np.sqrt(shape.mesh.area) * way / np.linalg.norm(way)
        found = with_component(found, shape.mesh.vertices[vertices] + thrown, faces.reshape(-1, 3))
    return found


def _pieces(shape: Shape, rng: np.random.Generator) -> TriangleMesh:
    first = int(rng.integers(shape.n_vertices))
    ends = shape.sampling("geodesic", _LIMBS, (first,)).indices[1:]
    distances = shape.metric("geodesic").distances(ends) / shape.size
    near, far = _RING
    rings = np.any((distances > near) & (distances < far), axis=0)
    kept = ~rings[shape.mesh.faces].any(axis=1)
    return triangle_mesh(shape.mesh.vertices, shape.mesh.faces[kept])


CONDITIONS: Mapping[str, Condition] = {
    "as it is": lambda shape, _: shape.mesh,
    "small ball": _ball(0.04),
    "ball": _ball(0.2),
    "floor": _floor,
    "debris": _debris,
    "in pieces": _pieces,
}


@dataclass(frozen=True)
class ScanAnswer:
    """The answer for a scan and another shape, judged.

    Parameters
    ----------
    error
        Mean geodesic error over √area.
    right
        Whether that counts as right, and no more than a tenth of the points are lost.
    lost
        Points that both shapes have, and one has no image of.
    probability
        That the answer is right, by its confidence.
    seconds
        Spectra included.
    """

    error: float
    right: bool
    lost: int
    probability: float
    seconds: float


def scanned(known: KnownShape, condition: Condition, seed: int) -> KnownShape:
    """Return a scan of a shape, of which the truth is known."""
    mesh = condition(known.shape, np.random.default_rng(seed))

    def vertices(truth: IntArray | None) -> IntArray | None:
        if truth is None:
            return None
        return np.where(truth >= 0, mesh.vertices_of(np.maximum(truth, 0)), -1)

    return replace(
        known,
        shape=Shape(mesh),
        truth=vertices(known.truth),
        symmetric_truth=vertices(known.symmetric_truth),
    )


def answered(source: KnownShape, target: KnownShape, options: MatchOptions) -> ScanAnswer:
    """Match a scan and another shape."""
    started = time.perf_counter()
    answer, found = judged(source, target, options)
    seconds = time.perf_counter() - started
    assert found.dense is not None
    assert found.dense.inverse is not None
    assert source.truth is not None
    assert target.truth is not None
    both = (source.truth >= 0) & (target.truth >= 0)
    lost = 0
    for one, mapped in ((source, found.dense.source), (target, found.dense.inverse.source)):
        assert one.truth is not None
        own = one.shape.mesh.vertex_ids[one.truth[both]]
        lost += int((~np.isin(own, mapped)).sum())
    right = answer.error.right and lost <= _LOST * both.sum()
    return ScanAnswer(answer.error.direct, right, lost, answer.probability, seconds)


def main() -> None:
    """Scan a shape of each pair in all ways, match the pairs, print a table."""
    parser = command_line(__doc__, data=True)
    parser.add_argument("--points", type=int, default=32, help="matched before")
    pair_options(parser, classes=1)
    arguments = parsed(parser)
    pairs = known_pairs(parser, arguments)
    options = MatchOptions(points=arguments.points, dense=True)
    answers: dict[str, list[ScanAnswer]] = {name: [] for name in CONDITIONS}
    print(f"{'pair':40}{'scan':>12}{'mean':>10}{'lost':>8}{'sure':>8}{'seconds':>9}")
    for number, pair in enumerate(pairs):
        for name, condition in CONDITIONS.items():
            scans = [replace(one, shape=Shape(one.shape.mesh)) for one in pair]
            scans[number % 2] = scanned(pair[number % 2], condition, number)
            answer = answered(scans[0], scans[1], options)
            answers[name].append(answer)
            print(
                f"{pair[0].name + ' ' + pair[1].name:40}{name:>12}{answer.error:10.4f}"
                f"{answer.lost:8}{answer.probability:8.2f}{answer.seconds:9.1f}"
                + ("" if answer.right else "  wrong"),
                flush=True,
            )
    figures = {name: _figures(found) for name, found in answers.items()}
    for name, values in figures.items():
        print(f"{name:12}" + "".join(f"   {key} {value:.4g}" for key, value in values.items()))
    print_json(arguments, figures)


def _figures(answers: list[ScanAnswer]) -> dict[str, float]:
    right = np.array([one.right for one in answers])
    return {
        "mean": float(np.mean([one.error for one in answers])),
        "wrong": int((~right).sum()),
        "sure_and_wrong": sum(
            one.probability >= PROBABLY_RIGHT for one in answers if not one.right
        ),
        "seconds": float(np.mean([one.seconds for one in answers])),
    }


if __name__ == "__main__":
    main()
