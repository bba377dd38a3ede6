"""Figure 3, comparison with GMDS: ``python -m bench.figure3``.

Eight points are matched by geodesic distances alone, by both methods, on every pair of shapes of a
class; and again by ours with its default structures. The figure shows the pair on which the error
of GMDS exceeds ours most, with either structures, and the one on which both are best.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from bench.collection import KnownShape, known_pairs, pair_options
from bench.command_line import command_line, parsed, print_json
from bench.drawing import Matched, draw_pair, save
from bench.surface_error import FARTHEST, better_errors
from solver.arrays import FloatArray, IntArray
from solver.gmds import SurfacePoints, embed
from solver.matching import MatchOptions, match

PICTURE = Path("bench-output/figure3.png")
POINTS = 8
GEODESIC = MatchOptions(
    points=POINTS, metric=("geodesic",), descriptor=("none",), orientation=False
)
DEFAULT = MatchOptions(points=POINTS)


@dataclass(frozen=True, eq=False)
class Answer:
    """Result of one method on a pair.

    Attributes
    ----------
    here, there
        (K,) vertex indices, of points between vertices the nearest ones; without those that the
        target lacks.
    errors
        (K,) over √area, against the direct or the mirrored truth.
    distortion
        Root mean square distortion of a distance, over √area.
    """

    here: IntArray
    there: IntArray
    errors: FloatArray
    distortion: float

    @property
    def error(self) -> float:
        """Mean error."""
        return float(self.errors.mean())


@dataclass(frozen=True, eq=False)
class Compared:
    """A pair of shapes with the results of all methods."""

    source: KnownShape
    target: KnownShape
    gmds: Answer
    ours: Answer
    default: Answer

    @property
    def name(self) -> str:
        """Names of both shapes."""
        return f"{self.source.name} {self.target.name}"

    @property
    def best(self) -> tuple[str, Answer]:
        """Label and result of our better match."""
        return min(
            (("ours, geodesic", self.ours), ("ours", self.default)), key=lambda one: one[1].error
        )

    @property
    def answers(self) -> tuple[Answer, Answer, Answer]:
        """Results in the order of the table."""
        return self.gmds, self.ours, self.default


def compare(source: KnownShape, target: KnownShape) -> Compared:
    """Match a pair by both methods."""
    ours, default = (_matched(source, target, options) for options in (GEODESIC, DEFAULT))
    return Compared(source, target, _embedded(source, target), ours, default)


def _embedded(source: KnownShape, target: KnownShape) -> Answer:
    embedding = embed(source.shape, target.shape, POINTS)
    points = embedding.solution.answer
    there = points.nearest_vertices(target.shape.surface)
    kept, errors = better_errors(source, target, embedding.vertices, points)
    return Answer(embedding.vertices[kept], there[kept], errors, embedding.distortion)


def _matched(source: KnownShape, target: KnownShape, options: MatchOptions) -> Answer:
    found = match(source.shape, target.shape, options).best
    here = source.shape.mesh.vertices_of(found.source)
    there = target.shape.mesh.vertices_of(found.target)
    at_vertices = SurfacePoints.at_vertices(target.shape.surface, there)
    spread = found.distortion.second_order / (POINTS * (POINTS - 1))
    kept, errors = better_errors(source, target, here, at_vertices)
    return Answer(here[kept], there[kept], errors, float(np.sqrt(spread)))


def draw(cases: dict[str, Compared], path: Path) -> None:
    """Draw one row per case, GMDS on the left."""
    figure = Figure(figsize=(9.0, 3.6 * len(cases)), dpi=72, facecolor="white")
    grid = figure.subplots(len(cases), 2, squeeze=False)
    for row, (title, pair) in zip(grid, cases.items(), strict=True):
        for axes, (method, answer) in zip(row, (("GMDS", pair.gmds), pair.best), strict=True):
            right = answer.errors < FARTHEST
            meshes = pair.source.shape.surface, pair.target.shape.surface
            draw_pair(axes, Matched(*meshes, answer.here, answer.there, right))
            axes.set_title(
                f"{title}: {method}\n{int(right.sum())} of {len(right)} right, "
                f"mean error {answer.error:.2f}, distortion {answer.distortion:.3f}",
                fontsize=10,
            )
    save(figure, path)


def main() -> None:
    """Match all pairs by both methods, print a table and draw two pairs."""
    parser = command_line(__doc__, data=True)
    pair_options(parser, classes=6)
    arguments = parsed(parser)
    pairs = known_pairs(parser, arguments)
    found: list[Compared] = []
    methods = "GMDS", "ours, geodesic", "ours, default"
    print(f"{'':34}" + "".join(f"{method:^20}" for method in methods))
    print(f"{'pair':34}" + 3 * f"{'error':>9}{'distortion':>11}")
    for source, target in pairs:
        pair = compare(source, target)
        found.append(pair)
        cells = (f"{one.error:9.3f}{one.distortion:11.3f}" for one in pair.answers)
        print(f"{pair.name:34}" + "".join(cells), flush=True)
    wrong = max(found, key=lambda pair: pair.gmds.error - pair.best[1].error)
    alike = min(found, key=lambda pair: max(pair.gmds.error, pair.best[1].error))
    draw({"GMDS goes wrong": wrong, "both agree": alike}, PICTURE)
    figures: dict[str, float] = {"pairs": len(found)}
    for which, method in enumerate(("gmds", "ours_geodesic", "ours_default")):
        answers = [pair.answers[which] for pair in found]
        figures[f"mean_error_{method}"] = float(np.mean([one.error for one in answers]))
        figures[f"wrong_pairs_{method}"] = sum(
            bool((one.errors >= FARTHEST).any()) for one in answers
        )
    print(f"\nGMDS goes wrong: {wrong.name}; both agree: {alike.name}; {PICTURE}")
    print("   ".join(f"{name} {value:.3g}" for name, value in figures.items()))
    print_json(arguments, {**figures, "gmds_wrong": wrong.name, "agree": alike.name})


if __name__ == "__main__":
    main()
