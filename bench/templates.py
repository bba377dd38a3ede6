"""Quality of registered templates: ``python -m bench.templates``.

Mean and greatest distance between the registered template and its target over √area; flipped
triangles; and the mean distance of the vertices from their images under the dense map, for all
pairs of shapes of a class. With ``--data`` the class is a file's name up to its first digit;
``--across`` takes pairs of different classes.
"""

import time
from dataclasses import asdict, dataclass
from itertools import combinations

import numpy as np

from bench.collection import KnownShape, collection, pairs_within_classes, require
from bench.command_line import command_line, parsed, print_json
from solver.matching import MatchOptions, match
from solver.templates import register_template, surface_distance


@dataclass(frozen=True)
class TemplateQuality:
    """Quality of one registered template.

    Parameters
    ----------
    mean, greatest
        Distances between both surfaces, as :class:`.SurfaceDistance` has them.
    flipped, faces
        Numbers of flipped triangles, and of all.
    moved
        Mean distance of the vertices from their images under the dense map, over √area.
    seconds
        Of registering the template, without the match.
    probability
        That the match is right, by its confidence.
    """

    mean: float
    greatest: float
    flipped: int
    faces: int
    moved: float
    seconds: float
    probability: float


def quality(source: KnownShape, target: KnownShape) -> TemplateQuality:
    """Register a source as a template to a target, and measure it."""
    options = MatchOptions(dense=True, orientation=True, proof="candidates")
    found = match(source.shape, target.shape, options)
    assert found.dense is not None
    assert found.confidence is not None
    ours, theirs = source.shape.mesh, target.shape.mesh
    started = time.process_time()
    template = register_template(ours, theirs, found.dense)
    seconds = time.process_time() - started
    rows = np.searchsorted(found.dense.source, ours.vertex_ids)
    corners = theirs.vertices[theirs.vertices_of(found.dense.faces[rows].ravel())]
    images = np.einsum(
        "vc,vcd->vd", found.dense.barycentric[rows], corners.reshape(len(rows), 3, 3)
    )
    distance = surface_distance(template.positions, ours, theirs)
    moved = np.linalg.norm(template.positions - images, axis=1) / np.sqrt(theirs.area)
    return TemplateQuality(
        mean=distance.mean,
        greatest=distance.greatest,
        flipped=int(template.flipped.sum()),
        faces=ours.n_faces,
        moved=float(moved.mean()),
        seconds=seconds,
        probability=found.confidence.probability,
    )


def figures(found: list[TemplateQuality]) -> dict[str, float]:
    """Figures of all pairs, for a line of JSON."""
    flipped = np.array([one.flipped for one in found])
    return {
        "pairs": len(found),
        "mean": float(np.mean([one.mean for one in found])),
        "max": float(np.max([one.greatest for one in found])),
        "flipped": float(flipped.mean()),
        "most_flipped": float(flipped.max()),
        "without_flips": float((flipped == 0).mean()),
        "moved": float(np.mean([one.moved for one in found])),
        "seconds": float(np.mean([one.seconds for one in found])),
    }


def main() -> None:
    """Register the pairs, print a table."""
    parser = command_line(__doc__, data=True)
    parser.add_argument("--every", type=int, default=1, help="take every n-th pair only")
    parser.add_argument("--across", action="store_true", help="pairs of different classes")
    arguments = parsed(parser)
    shapes = collection(arguments.data)
    pairs = pairs_within_classes(shapes)
    if arguments.across:
        pairs = [(a, b) for a, b in combinations(shapes, 2) if a.category != b.category]
    require(parser, pairs)
    heads = "mean", "max", "flipped", "moved", "seconds", "sure"
    print(f"{'pair':40}" + "".join(f"{head:>10}" for head in heads))
    found = []
    for source, target in pairs[:: arguments.every]:
        one = quality(source, target)
        found.append(one)
        row = asdict(one)
        values = "".join(f"{row[name]:10.5f}" for name in ("mean", "greatest"))
        rest = f"{one.flipped:10d}{one.moved:10.4f}{one.seconds:10.1f}{one.probability:10.2f}"
        print(f"{source.name} {target.name}".ljust(40) + values + rest, flush=True)
    summary = figures(found)
    print("\n" + "   ".join(f"{name} {value:.4g}" for name, value in summary.items()))
    print_json(arguments, summary)


if __name__ == "__main__":
    main()
