"""Figure 2: matches by three combinations of structures under three transformations."""

from pathlib import Path

from matplotlib.figure import Figure

from bench.collection import Pair
from bench.correspondence import point_errors
from bench.drawing import Matched, draw_pair, save
from bench.structure_change import eight_points
from bench.surface_error import FARTHEST
from bench.transformed import BENDING, SCALE, TOPOLOGY
from solver.matching import MatchOptions, match
from solver.shape.choices import (
    CommuteTime,
    Diffusion,
    Geodesic,
    HeatKernelSignature,
    ScaleInvariantHeatKernelSignature,
)

COMBINATIONS = {
    "geodesic, HKS": eight_points(Geodesic(), HeatKernelSignature()),
    "diffusion, HKS": eight_points(Diffusion(), HeatKernelSignature()),
    "commute time, SI-HKS": eight_points(CommuteTime(), ScaleInvariantHeatKernelSignature()),
}

ROWS = BENDING, TOPOLOGY, SCALE


def matched_by(options: MatchOptions, pair: Pair) -> tuple[Matched, float]:
    """Match a pair: the match to draw, and its mean error over √area.

    Errors are against the direct or the mirrored truth, whichever is nearer.
    """
    source, target = pair
    found = match(source.shape, target.shape, options)
    kept, both = point_errors(source, target, found)
    errors = both[both.mean(axis=1).argmin()]
    drawn = Matched(
        source.shape.mesh,
        target.shape.mesh,
        found.best.source[kept],
        found.best.target[kept],
        errors < FARTHEST,
    )
    return drawn, float(errors.mean())


def draw_figure2(pairs: dict[str, Pair], path: Path) -> None:
    """Draw the figure.

    Parameters
    ----------
    pairs
        One for each of `ROWS`.
    path
        The PNG file to write.
    """
    figure = Figure(figsize=(11.0, 10.0), dpi=72, facecolor="white")
    grid = figure.subplots(len(ROWS), len(COMBINATIONS))
    for row, transformation in zip(grid, ROWS, strict=True):
        for axes, (name, options) in zip(row, COMBINATIONS.items(), strict=True):
            drawn, error = matched_by(options, pairs[transformation])
            draw_pair(axes, drawn)
            right = int(drawn.right.sum())
            axes.set_title(
                f"{transformation}: {name}\n{right} of {len(drawn.right)} right, "
                f"mean error {error:.2f}",
                fontsize=10,
            )
    save(figure, path)
