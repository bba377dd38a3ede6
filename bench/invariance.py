"""Invariance of the structures, Table 1 and Figure 2: ``python -m bench.invariance``.

Shapes are bent, glued (two pairs of points that are near in space), pierced, scaled, made noisy and
remeshed, by `bench.transformed`. The *change* of a structure at corresponding points is relative to
its difference between other points (`bench.structure_change.change`): 0 is invariant, 1 is as
different as another point. Shapes are not normalised. The greatest change over the shapes counts,
since invariance is to every transformation of a class: "yes" below 0.15, "no" from 0.4. An asterisk
marks differences from Table 1.

*Error* is that of matching eight points with equal weight of local and global structure (6.1): the
mean geodesic distance over √area from the truth or its mirror image. A descriptor is joined by the
commute-time metric, a metric by SI-HKS.
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from bench.collection import Pair, read_collection, require
from bench.command_line import command_line, parsed, print_json
from bench.figure2 import COMBINATIONS, ROWS, draw_figure2
from bench.structure_change import (
    POINTWISE,
    assignment_error,
    change,
    matching_error,
    partners_of,
    structures,
)
from bench.transformed import (
    BENDING,
    SCALE,
    TOPOLOGY,
    TRANSFORMATIONS,
    generated_pairs,
    passage_pairs,
    real_pairs,
)
from solver.shape.choices import DEGREES, Degree, Photometric, Structure

THRESHOLDS: Mapping[Degree, float] = {"yes": 0.15, "approx": 0.4, "no": np.inf}
"""Upper bound of the change for each degree of invariance."""

PAPER: Mapping[str, tuple[Degree, Degree, Degree]] = {
    "photometric": ("yes", "yes", "yes"),
    "geodesic_histogram": ("yes", "no", "no"),
    "gaussian_curvature": ("yes", "no", "no"),
    "conformal_factor": ("yes", "no", "no"),
    "eigenfunctions": ("yes", "no", "yes"),
    "hks": ("yes", "approx", "no"),
    "si_hks": ("yes", "approx", "yes"),
    "geodesic": ("yes", "no", "no"),
    "diffusion": ("yes", "approx", "no"),
    "commute_time": ("yes", "approx", "yes"),
}
"""Table 1: bending, topology, scale. Its row of colours is for single points."""

COMPARED = BENDING, TOPOLOGY, SCALE

Figures = dict[str, dict[str, list[float]]]
"""One number per pair, by structure and transformation."""


def label(structure: Structure) -> str:
    """Name of a structure's row."""
    return "photometric at a point" if structure == POINTWISE else structure.name


def paper_says(structure: Structure, transformation: str) -> Degree | None:
    """Entry of Table 1; ``None`` if it has none."""
    averaged = isinstance(structure, Photometric) and structure != POINTWISE
    if transformation not in COMPARED or structure.name not in PAPER or averaged:
        return None
    return PAPER[structure.name][COMPARED.index(transformation)]


def degree(changes: list[float]) -> Degree:
    """Degree of invariance by the greatest change, in the words of Table 1."""
    return next(word for word in DEGREES if max(changes) < THRESHOLDS[word])


def measure(pairs: list[tuple[str, Pair]]) -> tuple[Figures, Figures, Figures]:
    """Measure changes of every structure, and errors of matches of separate and of equal samples.

    Errors are also measured for the combinations of Figure 2.
    """
    changes: Figures = {}
    own: Figures = {}
    same: Figures = {}
    options = {label(structure): partners_of(structure) for structure in structures()}
    for transformation, pair in pairs:
        for structure in structures():
            row = changes.setdefault(label(structure), {})
            row.setdefault(transformation, []).append(change(structure, pair))
        for name, chosen in (options | COMBINATIONS).items():
            error = matching_error(chosen, pair), assignment_error(chosen, pair)
            for figures, value in zip((own, same), error, strict=True):
                figures.setdefault(name, {}).setdefault(transformation, []).append(value)
    return changes, own, same


def print_changes(changes: Figures) -> tuple[int, int]:
    """Print Table 1 as measured: mean and greatest change, and the degree of invariance.

    Returns
    -------
    agreeing, compared
        Number of entries that agree with Table 1, and of entries that are in both.
    """
    print("change: mean, greatest, degree of invariance; * where Table 1 differs")
    print(f"{'':23}" + "".join(f"{name:>21}" for name in TRANSFORMATIONS))
    agreeing = compared = 0
    for structure in structures():
        cells = []
        for transformation in TRANSFORMATIONS:
            found = changes[label(structure)][transformation]
            word, expected = degree(found), paper_says(structure, transformation)
            compared += expected is not None
            agreeing += expected == word
            mark = " " if expected in (None, word) else "*"
            cells.append(f"{np.mean(found):6.3f}{max(found):7.3f} {word:>6}{mark}")
        print(f"{label(structure):23}" + "".join(cells))
    print(f"\n{agreeing} of the {compared} entries that Table 1 has too are as it says\n")
    return agreeing, compared


def print_errors(title: str, errors: Figures) -> None:
    """Print mean errors and the share of matches with errors over a quarter of √area."""
    print(f"{title}: mean error, share of matches over 0.25")
    print(f"{'':23}" + "".join(f"{name:>14}" for name in TRANSFORMATIONS))
    for row, by_transformation in errors.items():
        cells = [np.array(by_transformation[name]) for name in TRANSFORMATIONS]
        print(f"{row:23}" + "".join(f"{c.mean():8.3f}{(c > 0.25).mean():5.0%} " for c in cells))
    print()


def print_passages(resolution: int) -> Figures:
    """Measure and print the change by the width of the passage between glued parts."""
    figures: Figures = {}
    print("hands glued to legs: change by the radius of what is glued, over √area")
    for radius, pair in passage_pairs(resolution):
        for structure in structures():
            figures.setdefault(label(structure), {})[radius] = [change(structure, pair)]
    radii = list(next(iter(figures.values())))
    print(f"{'':23}" + "".join(f"{radius:>12}" for radius in radii))
    for row, by_radius in figures.items():
        print(f"{row:23}" + "".join(f"{by_radius[radius][0]:12.3f}" for radius in radii))
    print()
    return figures


def figure2_pairs(pairs: list[tuple[str, Pair]]) -> dict[str, Pair]:
    """One pair for each row of Figure 2: humans, if there are any."""
    humans = [entry for entry in pairs if entry[1][0].category in ("human", "michael")]
    return {name: next(pair for done, pair in humans or pairs if done == name) for name in ROWS}


def main() -> None:
    """Measure, print tables and draw Figure 2."""
    parser = command_line(__doc__, data=True)
    parser.add_argument("--classes", type=int, default=6, help="generated classes, without --data")
    parser.add_argument("--resolution", type=int, default=3000, help="vertices of generated shapes")
    parser.add_argument("--output", type=Path, default=Path("bench-output"))
    arguments = parsed(parser)
    if arguments.data:
        pairs = list(real_pairs(read_collection(arguments.data)))
        require(parser, pairs)
    else:
        pairs = list(generated_pairs(arguments.resolution, arguments.classes))
    changes, own, same = measure(pairs)
    agreeing, compared = print_changes(changes)
    print_errors("eight points of each shape", own)
    print_errors("eight points and their images", same)
    passages = print_passages(arguments.resolution)
    picture = arguments.output / "figure2.png"
    draw_figure2(figure2_pairs(pairs), picture)
    print(f"Figure 2: {picture}")
    figures = {
        "agreeing": agreeing,
        "compared": compared,
        "changes": changes,
        "errors": own,
        "errors_of_images": same,
        "passages": passages,
    }
    print_json(arguments, figures)


if __name__ == "__main__":
    main()
