"""Robustness of dense maps to changes of the input: ``python -m bench.robust``.

The target of each pair is changed in ways that leave the correspondence as it was: winding, noise,
unit of length, position, triangulation. The direct error of the dense map is compared with that of
the pair as it is. A reflection in space is different: the mirrored surface is that of a body with
left and right exchanged, so that the mirrored truth becomes the direct one, where it is known; a
body that is not symmetric is no longer the same body, and the answer should say so.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from bench.calibration import shown
from bench.collection import KnownShape, known_pairs, pair_options
from bench.command_line import command_line, parsed, print_json
from bench.map_error import WRONG, map_error
from bench.varied_pairs import AS_IT_IS, KINDS, LOPSIDED, varied_pair
from solver.arrays import FloatArray, IntArray
from solver.matching import MatchOptions, match
from solver.mesh import TriangleMesh, simplified, triangle_mesh, vertex_normals
from solver.registration.surface import MIRROR
from solver.shape import Shape
from synthetic import remeshed, subdivided

REMESHED = "remeshed to 0.6"

_NOISE = 0.005
"""Standard deviation of the noise along the normals, over √area."""
_FACTOR = 1000.0
_TURN = 130.0, 25.0, -70.0
_SHARE = 0.6
"""Vertices of the new triangulation per vertex of the old one."""

Change = Callable[[TriangleMesh], tuple[TriangleMesh, IntArray]]
"""A changed mesh, and the (V,) vertex of it that stands for each vertex of the mesh."""


def _every(mesh: TriangleMesh) -> IntArray:
    return np.arange(mesh.n_vertices)


def _moved(mesh: TriangleMesh, vertices: FloatArray) -> tuple[TriangleMesh, IntArray]:
    return triangle_mesh(vertices, mesh.faces), _every(mesh)


def _flipped(mesh: TriangleMesh) -> tuple[TriangleMesh, IntArray]:
    return triangle_mesh(mesh.vertices, mesh.faces[:, ::-1]), _every(mesh)


def _noisy(mesh: TriangleMesh) -> tuple[TriangleMesh, IntArray]:
    distance = np.random.default_rng(5).normal(0.0, _NOISE * np.sqrt(mesh.area), mesh.n_vertices)
    normals = vertex_normals(mesh.vertices, mesh.faces)
    return _moved(mesh, mesh.vertices + distance[:, None] * normals)


def _scaled(mesh: TriangleMesh) -> tuple[TriangleMesh, IntArray]:
    return _moved(mesh, _FACTOR * mesh.vertices)


def _turned(mesh: TriangleMesh) -> tuple[TriangleMesh, IntArray]:
    turn = Rotation.from_euler("xyz", _TURN, degrees=True).as_matrix()
    return _moved(mesh, mesh.vertices @ turn.T + 3.0 * np.sqrt(mesh.area))


def simplified_to(mesh: TriangleMesh, vertices: int) -> tuple[TriangleMesh, IntArray]:
    """Return a mesh of fewer vertices, and that into which each vertex was collapsed."""
    coarse = simplified(mesh, vertices)
    image = coarse.vertices_of(mesh.vertex_ids)
    return triangle_mesh(coarse.vertices, coarse.faces), image


def _simplified(mesh: TriangleMesh) -> tuple[TriangleMesh, IntArray]:
    return simplified_to(mesh, mesh.n_vertices // 2)


def _subdivided(mesh: TriangleMesh) -> tuple[TriangleMesh, IntArray]:
    return triangle_mesh(*subdivided(mesh.vertices, mesh.faces)), _every(mesh)


def _remeshed(mesh: TriangleMesh) -> tuple[TriangleMesh, IntArray]:
    found = remeshed(mesh, round(_SHARE * mesh.n_vertices), seed=3)
    return found.mesh, found.image


def _reflected(mesh: TriangleMesh) -> tuple[TriangleMesh, IntArray]:
    mirrored = mesh.vertices * MIRROR
    return triangle_mesh(mirrored, mesh.faces[:, ::-1]), _every(mesh)


CHANGES: Mapping[str, Change] = {
    "winding flipped": _flipped,
    "noise of 0.5 %": _noisy,
    "lengths times 1000": _scaled,
    "turned and moved": _turned,
    "simplified to half": _simplified,
    "subdivided to four times": _subdivided,
    REMESHED: _remeshed,
    "reflected": _reflected,
}
"""What is done to the target. Remeshing, for generated shapes alone, needs a closed surface."""


@dataclass(frozen=True)
class RobustAnswer:
    """Errors of one answer, and what it says of itself.

    Parameters
    ----------
    direct, mirrored
        Mean errors over √area, to the direct and the mirrored truth; the latter is ``None`` where
        nobody knows it. They are exchanged where one of the shapes is reflected.
    probability
        That the answer is right, by its confidence.
    said
        Warnings and reasons for doubt.
    """

    direct: float
    mirrored: float | None
    probability: float
    said: tuple[str, ...]


def answered(source: KnownShape, target: KnownShape, options: MatchOptions) -> RobustAnswer:
    """Match two shapes densely, on fresh shapes."""
    fresh = [replace(one, shape=Shape(one.shape.mesh)) for one in (source, target)]
    found = match(fresh[0].shape, fresh[1].shape, options)
    assert found.dense is not None
    assert found.confidence is not None
    mirrored = None
    if target.symmetric_truth is not None:
        other = replace(fresh[1], truth=target.symmetric_truth, symmetric_truth=None)
        mirrored = map_error(fresh[0], other, found.dense).direct
    return RobustAnswer(
        map_error(fresh[0], fresh[1], found.dense).direct,
        mirrored,
        found.confidence.probability,
        (*found.warnings, *found.confidence.reasons),
    )


def changed(one: KnownShape, change: Change) -> KnownShape:
    """Change a shape, and carry its truth along: a reflection exchanges direct and mirrored."""
    mesh, image = change(one.shape.mesh)

    def carried(truth: IntArray | None) -> IntArray | None:
        return None if truth is None else np.where(truth < 0, -1, image[truth])

    truths = [carried(one.truth), carried(one.symmetric_truth)]
    if change is _reflected and one.symmetric_truth is not None:
        truths = truths[::-1]
    return KnownShape(one.name, one.category, Shape(mesh), *truths)


@dataclass(frozen=True)
class Robustness:
    """Answers to pairs as they are, and to the same pairs changed, at least one."""

    before: tuple[RobustAnswer, ...]
    after: tuple[RobustAnswer, ...]

    def figures(self) -> dict[str, float]:
        """Means over the pairs, and the share of those whose answer says more than before."""
        before, after = (
            np.array([one.direct for one in side]) for side in (self.before, self.after)
        )
        told = [
            bool(set(new.said) - set(old.said))
            for old, new in zip(self.before, self.after, strict=True)
        ]
        return {
            "pairs": len(before),
            "before": float(before.mean()),
            "after": float(after.mean()),
            "greatest_change": float(np.abs(after - before).max()),
            "wrong_before": float((before > WRONG).mean()),
            "wrong_after": float((after > WRONG).mean()),
            "probability_before": float(np.mean([one.probability for one in self.before])),
            "probability_after": float(np.mean([one.probability for one in self.after])),
            "told": float(np.mean(told)),
        }


def measured(
    pairs: list[tuple[KnownShape, KnownShape]], changes: Mapping[str, Change]
) -> dict[str, Robustness]:
    """Match all pairs as they are and with every change."""
    options = MatchOptions(dense=True)
    before: list[RobustAnswer] = []
    after: dict[str, list[RobustAnswer]] = {name: [] for name in changes}
    for source, target in pairs:
        before.append(answered(source, target, options))
        print(f"{source.name} {target.name}: {before[-1].direct:.4f}", flush=True)
        for name, change in changes.items():
            found = answered(source, changed(target, change), options)
            after[name].append(found)
            new = [said for said in found.said if said not in before[-1].said]
            print(
                f"  {name:26}{found.direct:8.4f}{shown(found.mirrored):>8}{found.probability:7.2f}"
                f"  {'; '.join(new)}",
                flush=True,
            )
    return {name: Robustness(tuple(before), tuple(found)) for name, found in after.items()}


def main() -> None:
    """Change the targets of the pairs, print a table."""
    parser = command_line(__doc__, data=True)
    pair_options(parser, classes=2, every=3)
    arguments = parsed(parser)
    pairs = known_pairs(parser, arguments)
    changes = dict(CHANGES)
    if arguments.data:
        del changes[REMESHED]
    else:
        lopsided = varied_pair(list(KINDS).index(LOPSIDED), condition=AS_IT_IS)
        pairs.append((lopsided.source, lopsided.target))
    print(
        "pair and its direct error; after each change direct, mirrored, probability, what is said"
    )
    figures = {name: found.figures() for name, found in measured(pairs, changes).items()}
    print_table(figures)
    print_json(arguments, figures)


def print_table(figures: Mapping[str, Mapping[str, float]]) -> None:
    """Print the figures of every change, a line each."""
    heads = "before", "after", "greatest", "wrong", "after", "sure", "after", "told"
    print(f"\n{'change':26}" + "".join(f"{head:>10}" for head in heads))
    for name, row in figures.items():
        values = [value for key, value in row.items() if key != "pairs"]
        print(f"{name:26}" + "".join(f"{value:10.4f}" for value in values))


if __name__ == "__main__":
    main()
