"""Shapes of an experiment: a folder of meshes, or generated ones."""

import re
from argparse import ArgumentParser, Namespace
from collections.abc import Sized
from dataclasses import dataclass
from itertools import combinations, islice
from pathlib import Path
from typing import TypeAlias

import numpy as np

from bench.symmetry import mirrored_vertices
from solver.arrays import IntArray
from solver.mesh import MESH_FORMATS, read_mesh, triangle_mesh
from solver.shape import Shape
from synthetic import CLASSES, OBJECTS, articulated, correspondence, individuals


@dataclass(frozen=True, eq=False)
class KnownShape:
    """A shape whose points are known from one shape of its class to the next.

    Parameters
    ----------
    name, category
        The class is the name up to its first digit.
    shape
        What is matched.
    truth
        (T,) vertices; those of two shapes of a class correspond, or ``None`` if nobody knows.
    symmetric_truth
        (T,) the same under the left-right intrinsic symmetry.
    """

    name: str
    category: str
    shape: Shape
    truth: IntArray | None
    symmetric_truth: IntArray | None


Pair: TypeAlias = tuple[KnownShape, KnownShape]


def read_collection(folder: Path) -> list[KnownShape]:
    """Read every mesh of a folder, with ``NAME.vts`` and ``NAME.sym.vts`` where they are.

    Parameters
    ----------
    folder
        A ``.vts`` file has one 1-based vertex number a line, of the same point of the class.
    """
    formats = set(MESH_FORMATS) - {"txt", "csv"}  # more often tables and notes than points
    paths = sorted(path for path in folder.iterdir() if path.suffix[1:].lower() in formats)
    shapes = []
    for path in paths:
        mesh = read_mesh(path.read_bytes(), path.suffix[1:].lower())
        truths = [_read_vertices(path.with_suffix(suffix)) for suffix in (".vts", ".sym.vts")]
        shapes.append(KnownShape(path.stem, category_of(path.stem), Shape(mesh), *truths))
    return shapes


def generated_collection(resolution: int = 3000, classes: int = 1) -> list[KnownShape]:
    """Articulated figures in four poses each, every one triangulated on its own.

    Parameters
    ----------
    resolution
        Vertices of each shape.
    classes
        How many of :data:`synthetic.CLASSES`, the human first. One takes about 5 seconds.

    Returns
    -------
    shapes
        Four of a class, named like ``cat2-turning``.
    """
    shapes = []
    for category, known in islice(CLASSES.items(), classes):
        figures = [
            articulated(category, pose, resolution, seed) for seed, pose in enumerate(known.poses)
        ]
        first = figures[0]
        mirrored = mirrored_vertices(first.rest)
        for number, (pose, figure) in enumerate(zip(known.poses, figures, strict=True)):
            truth = correspondence(first, figure)
            shape = Shape(triangle_mesh(figure.vertices, figure.faces))
            name = f"{category}{number}-{pose}"
            shapes.append(KnownShape(name, category, shape, truth, truth[mirrored]))
    return shapes


def collection(folder: Path | None, resolution: int = 3000, classes: int = 1) -> list[KnownShape]:
    """Read the meshes of a folder, or generate shapes if there is none."""
    return read_collection(folder) if folder else generated_collection(resolution, classes)


def category_of(name: str) -> str:
    """Class of a shape: its name up to the first digit."""
    return re.split(r"\d", name, maxsplit=1)[0]


def pairs_within_classes(shapes: list[KnownShape]) -> list[Pair]:
    """All unordered pairs of shapes of one class."""
    return [(a, b) for a, b in combinations(shapes, 2) if a.category == b.category]


def pairs_of_known_truth(shapes: list[KnownShape]) -> list[Pair]:
    """Those of the pairs of which it is known what corresponds, at least of one point."""
    return [
        (a, b)
        for a, b in pairs_within_classes(shapes)
        if a.truth is not None and b.truth is not None and ((a.truth >= 0) & (b.truth >= 0)).any()
    ]


def pair_options(parser: ArgumentParser, classes: int, every: int = 1) -> None:
    """Add the options of :func:`known_pairs`, with these defaults."""
    parser.add_argument("--every", type=int, default=every, help="take every n-th pair only")
    parser.add_argument(
        "--classes", type=int, default=classes, help="generated ones, without --data"
    )


def known_pairs(parser: ArgumentParser, arguments: Namespace, resolution: int = 3000) -> list[Pair]:
    """Pairs of known truth that a command line with :func:`pair_options` asks for.

    Without any, the program ends with a message.
    """
    shapes = collection(arguments.data, resolution, arguments.classes)
    pairs = pairs_of_known_truth(shapes)[:: arguments.every]
    require(parser, pairs)
    return pairs


def require(parser: ArgumentParser, found: Sized) -> None:
    """End the program with a message if there is nothing to measure."""
    if not found:
        parser.error(
            "nothing to measure: --data is a folder of meshes, of a class each up to its first"
            " digit; most experiments need two of a class with known points, NAME.vts"
        )


def known_of_classes(
    parser: ArgumentParser, shapes: list[KnownShape], classes: tuple[str, ...]
) -> list[KnownShape]:
    """Those of the shapes that are of these classes and have known points.

    Without any, the program ends with a message.
    """
    found = [one for one in shapes if one.category in classes and one.truth is not None]
    if not found:
        parser.error(f"--data has no shape with known points of {', '.join(classes)}")
    return found


def object_pairs(count: int, first: int = 0, deformation: float = 1.0) -> list[Pair]:
    """Two individuals of each of :data:`synthetic.OBJECTS`, of 2,000 and 2,500 vertices.

    Parameters
    ----------
    count
        Pairs of each kind.
    first
        Seed of the first ones.
    deformation
        Factor on the amplitude of the displacement that makes individuals differ.
    """
    pairs = []
    for seed in range(first, first + count):
        for kind in OBJECTS:
            one, other = (
                KnownShape(f"{kind}{seed}-{number}", kind, Shape(made.mesh), made.places, None)
                for number, made in enumerate(individuals(kind, seed, (2000, 2500), deformation))
            )
            pairs.append((one, other))
    return pairs


def _read_vertices(path: Path) -> IntArray | None:
    if not path.exists():
        return None
    return np.loadtxt(path, dtype=np.int64) - 1
