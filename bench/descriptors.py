"""Discriminative power of the descriptors: ``python -m bench.descriptors``.

For every descriptor, with default parameters, on pairs of shapes of a class: the correlation of its
values at corresponding points, and the rank of the corresponding point among all others by
similarity (0 if it is always the most similar, 50 % by chance). A descriptor that is symmetric
cannot rank a point above its mirror image.
"""

import time

import numpy as np

from bench.collection import KnownShape, known_pairs, pair_options
from bench.command_line import command_line, parsed, print_json
from solver.arrays import FloatArray, IntArray
from solver.shape.choices import DESCRIPTORS, Eigenfunctions
from solver.shape.descriptors import aligned_eigenfunctions

POINTS = 300
"""Corresponding points compared on each pair."""


def described(
    name: str, shapes: tuple[KnownShape, KnownShape], points: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Descriptors of both shapes at corresponding points."""
    truths = [shape.truth for shape in shapes]
    vertices = [truth[points] for truth in truths if truth is not None]
    if name == Eigenfunctions.name:
        spectra = [shape.shape.spectrum() for shape in shapes]
        return aligned_eigenfunctions(spectra[0], spectra[1], Eigenfunctions().count, *vertices)
    first, second = (
        shape.shape.descriptor(name, where) for shape, where in zip(shapes, vertices, strict=True)
    )
    return first, second


def correlation(first: FloatArray, second: FloatArray) -> float:
    """Correlation over all components, centred one by one."""
    a, b = (values - values.mean(axis=0) for values in (first, second))
    return float((a * b).sum() / np.sqrt((a * a).sum() * (b * b).sum()))


def rank(first: FloatArray, second: FloatArray) -> float:
    """Mean share of points that are more similar than the corresponding one."""
    distances = np.linalg.norm(first[:, None] - second[None], axis=2)
    return float((distances < np.diag(distances)[:, None]).mean())


def main() -> None:
    """Compare the pairs and print a table."""
    parser = command_line(__doc__, data=True)
    pair_options(parser, classes=1)
    arguments = parsed(parser)
    pairs = known_pairs(parser, arguments)
    random = np.random.default_rng(0)
    figures = {}
    print(f"{'descriptor':20}{'correlation':>12}{'rank':>8}{'seconds a shape':>17}")
    for name, kind in DESCRIPTORS.items():
        if name == "none" or (kind.colored and any(a.shape.mesh.colors is None for a, _ in pairs)):
            continue
        rows = []
        for pair in pairs:
            known = min(len(shape.truth) for shape in pair if shape.truth is not None)
            points = random.choice(known, min(POINTS, known), replace=False)
            for shape in pair:
                shape.shape.spectrum()
            started = time.perf_counter()
            first, second = described(name, pair, points)
            seconds = time.perf_counter() - started
            rows.append((correlation(first, second), rank(first, second), 0.5 * seconds))
        figures[name] = dict(
            zip(("correlation", "rank", "seconds"), np.mean(rows, axis=0).tolist(), strict=True)
        )
        values = figures[name]
        print(
            f"{name:20}{values['correlation']:12.3f}{values['rank']:8.1%}{values['seconds']:17.2f}"
        )
    print_json(arguments, figures)


if __name__ == "__main__":
    main()
