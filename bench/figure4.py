"""Figure 4, dissimilarities of six classes by GMDS and by ours: ``python -m bench.figure4``.

Every pair of 24 shapes is compared by six points. Ours is the least distortion of a bijection,
proven; of commute times as a user gets it, and of geodesic distances for a comparison on GMDS's own
ground. GMDS embeds the six points of either shape into the other, and counts the better one.
Retrieval is scored by mean average precision.
"""

import time
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy.spatial.distance import squareform

from bench.collection import KnownShape, collection, require
from bench.command_line import command_line, parsed, print_json
from bench.drawing import save
from solver.arrays import FloatArray
from solver.gmds import InterpolatedMetric, embed
from solver.similarity import (
    SignatureCollection,
    SimilarityOptions,
    dissimilarities,
    number_of_pairs,
    pairs_between,
    retrieval_scores,
    signature,
)

PICTURE = Path("bench-output/figure4.png")


@dataclass(frozen=True, eq=False)
class Compared:
    """A dissimilarity matrix and what it took.

    Attributes
    ----------
    values
        (K, K).
    certified_share
        Share of the pairs whose optimum is proven.
    seconds
        Of all pairs, once each shape's own structures are known.
    """

    values: FloatArray
    certified_share: float
    seconds: float


def ours(shapes: list[KnownShape], options: SimilarityOptions) -> Compared:
    """Least distortions of bijections."""
    signatures = [signature(known.shape, options) for known in shapes]
    pairs = pairs_between(len(shapes), 0, number_of_pairs(len(shapes)))
    compared = SignatureCollection.of(signatures, options.points)
    dissimilarities(compared, pairs[:1], options)  # compiles
    started = time.perf_counter()
    found = dissimilarities(compared, pairs, options)
    seconds = time.perf_counter() - started
    return Compared(squareform(found.costs), 1.0, seconds)


def by_gmds(shapes: list[KnownShape], points: int) -> Compared:
    """Root mean square distortions of embeddings, of the better of both directions."""
    metrics = [
        InterpolatedMetric(known.shape.metric("geodesic"), known.shape.surface) for known in shapes
    ]
    first = shapes[0].shape, shapes[1].shape
    embed(*first, points, metric=metrics[1])  # compiles
    values = np.zeros((len(shapes), len(shapes)))
    started = time.perf_counter()
    for i, j in combinations(range(len(shapes)), 2):
        there = embed(shapes[i].shape, shapes[j].shape, points, metric=metrics[j])
        back = embed(shapes[j].shape, shapes[i].shape, points, metric=metrics[i])
        values[i, j] = values[j, i] = min(there.distortion, back.distortion)
    return Compared(values, 0.0, time.perf_counter() - started)


def draw(matrices: dict[str, FloatArray], shapes: list[KnownShape], path: Path) -> None:
    """Draw the matrices side by side, dark where shapes are alike."""
    names = [known.category for known in shapes]
    borders = [i for i in range(1, len(names)) if names[i] != names[i - 1]]
    middles = [
        0.5 * (a + b - 1) for a, b in zip([0, *borders], [*borders, len(names)], strict=True)
    ]
    figure = Figure(figsize=(4.6 * len(matrices), 4.9), dpi=90, facecolor="white")
    for axes, (title, values) in zip(
        figure.subplots(1, len(matrices)), matrices.items(), strict=True
    ):
        axes.imshow(values, cmap="gray", vmin=0.0, vmax=float(np.quantile(values, 0.95)))
        for border in borders:
            axes.axhline(border - 0.5, color="#d1362f", linewidth=0.5)
            axes.axvline(border - 0.5, color="#d1362f", linewidth=0.5)
        axes.set_xticks(middles, [names[int(m)] for m in middles], rotation=45, ha="right")
        axes.set_yticks(middles, [names[int(m)] for m in middles])
        axes.tick_params(length=0, labelsize=9)
        axes.set_title(title, fontsize=11)
    save(figure, path)


def scored(compared: dict[str, Compared], labels: list[str], pairs: int) -> dict[str, float | None]:
    """Print a row for each method, and return its mean average precision."""
    print(f"{'':18}{'mAP':>9}{'first':>9}{'proven':>9}{'pairs/s':>12}")
    precisions = {}
    for name, found in compared.items():
        score = retrieval_scores(found.values, labels)
        precisions[name] = score.mean_average_precision
        print(
            f"{name:18}{score.mean_average_precision:9.1%}{score.precision_at_1:9.1%}"
            f"{found.certified_share:9.0%}{pairs / found.seconds:12.1f}"
        )
    return precisions


def main() -> None:
    """Compare all pairs, print a table, draw the figure."""
    parser = command_line(__doc__, data=True)
    parser.add_argument("--points", type=int, default=6)
    arguments = parsed(parser)
    shapes = collection(arguments.data, classes=6)
    require(parser, shapes[1:])
    started = time.perf_counter()
    for known in shapes:
        known.shape.spectrum()
    print(f"{len(shapes)} shapes, spectra {time.perf_counter() - started:.1f} s")
    geodesic = SimilarityOptions(points=arguments.points, metric="geodesic")
    compared = {
        "GMDS": by_gmds(shapes, arguments.points),
        "ours, geodesic": ours(shapes, geodesic),
        "ours": ours(shapes, SimilarityOptions(points=arguments.points)),
    }
    pairs = len(shapes) * (len(shapes) - 1) // 2
    precisions = scored(compared, [known.category for known in shapes], pairs)
    compared_values = {
        # The roots of mean squared distortions are what GMDS measures too.
        f"{name}: mAP {precisions[name]:.1%}": (
            found.values if name == "GMDS" else np.sqrt(found.values)
        )
        for name, found in compared.items()
    }
    draw(compared_values, shapes, PICTURE)
    print(f"\n{PICTURE}")
    figures = {
        "points": arguments.points,
        "shapes": len(shapes),
        "map_ours": precisions["ours"],
        "map_ours_geodesic": precisions["ours, geodesic"],
        "map_gmds": precisions["GMDS"],
        "certified_share": compared["ours"].certified_share,
        "pairs_per_second": pairs / compared["ours"].seconds,
        "pairs_per_second_gmds": pairs / compared["GMDS"].seconds,
    }
    print_json(arguments, figures)


if __name__ == "__main__":
    main()
