"""Dense maps of point clouds sampled from meshes: ``python -m bench.clouds``.

Points are sampled uniformly at random on the surface of a mesh, with and without noise, and matched
with that mesh and with another one of its class. Errors are geodesic distances on the target over
√area, of images between vertices to the direct truth, which is known of the vertex nearest to the
point sampled. With ``--data`` the class is a file's name up to its first digit.
"""

import time

import numpy as np

from bench.collection import KnownShape, category_of, known_pairs, pair_options
from bench.command_line import command_line, parsed, print_json
from bench.map_error import COMPARED
from bench.surface_error import corner_errors, truths_of
from solver.arrays import FloatArray, IntArray
from solver.matching import MatchOptions, match
from solver.mesh import TriangleMesh, read_mesh, triangle_areas
from solver.shape import Shape


def sampled(mesh: TriangleMesh, count: int, noise: float) -> tuple[FloatArray, IntArray]:
    """Sample points on a surface, uniformly by area.

    Parameters
    ----------
    mesh
        The surface.
    count
        Number N of points.
    noise
        Standard deviation of each coordinate, over the diagonal of the bounding box.

    Returns
    -------
    (N, 3) points, and (N,) the vertex nearest to each, of its triangle.
    """
    random = np.random.default_rng(1)
    areas = triangle_areas(mesh.vertices, mesh.faces)
    faces = random.choice(len(areas), count, p=areas / areas.sum())
    weights = random.dirichlet(np.ones(3), count)
    points = (mesh.vertices[mesh.faces[faces]] * weights[:, :, None]).sum(axis=1)
    size = float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
    nearest = mesh.faces[faces, weights.argmax(axis=1)]
    return points + noise * size * random.standard_normal(points.shape), nearest


def cloud_of(points: FloatArray) -> TriangleMesh:
    """Read points as a file of the format XYZ."""
    lines = [" ".join(map(repr, place)) for place in points.tolist()]
    return read_mesh(("\n".join(lines) + "\n").encode(), "xyz")


def errors_of(
    source: KnownShape, target: KnownShape, cloud: TriangleMesh, nearest: IntArray, points: int
) -> tuple[FloatArray, float]:
    """Match a cloud sampled from a source with a target, and compare with the truth.

    Returns
    -------
    Errors of at most `COMPARED` points over √area, and the probability that the answer is right.
    """
    found = match(Shape(cloud), target.shape, MatchOptions(points=points, dense=True))
    assert found.dense is not None
    assert found.confidence is not None
    rows = np.linspace(0, len(found.dense.source) - 1, COMPARED).astype(np.int64)
    truth = nearest[found.dense.source[rows]]
    if target is not source:
        kept, (truth, *_) = truths_of(source, target, truth)
        rows = rows[kept]
    corners = target.shape.mesh.vertices_of(found.dense.faces[rows].ravel()).reshape(-1, 3)
    errors = corner_errors(target, corners, found.dense.barycentric[rows], truth)
    return errors, found.confidence.probability


def main() -> None:
    """Sample clouds, match them, print a table."""
    parser = command_line(__doc__, data=True)
    parser.add_argument("--count", type=int, default=10_000, help="points of a cloud")
    parser.add_argument("--noise", type=float, nargs="+", default=[0.0, 0.002])
    parser.add_argument("--points", type=int, default=32, help="matched before")
    pair_options(parser, classes=1)
    arguments = parsed(parser)
    pairs = known_pairs(parser, arguments)
    first = {category_of(source.name): (source, target) for source, target in reversed(pairs)}
    heads = "noise", "triangles", "surface s", "mean", "median", "sure", "match s"
    print(f"{'cloud and target':40}" + "".join(f"{head:>10}" for head in heads))
    figures = []
    for source, other in first.values():
        for noise in arguments.noise:
            points, nearest = sampled(source.shape.mesh, arguments.count, noise)
            started = time.perf_counter()
            cloud = cloud_of(points)
            seconds = time.perf_counter() - started
            for target in (source, other):
                started = time.perf_counter()
                errors, sure = errors_of(source, target, cloud, nearest, arguments.points)
                row = {
                    "noise": noise,
                    "triangles": cloud.n_faces,
                    "seconds_surface": seconds,
                    "mean": float(errors.mean()),
                    "median": float(np.median(errors)),
                    "probability": sure,
                    "seconds": time.perf_counter() - started,
                }
                name = f"{source.name} {target.name}"
                print(
                    f"{name:40}" + "".join(f"{value:10.4g}" for value in row.values()), flush=True
                )
                figures.append({"source": source.name, "target": target.name, **row})
    print_json(arguments, figures)


if __name__ == "__main__":
    main()
