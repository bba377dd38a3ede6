"""Times and errors of the methods of computing geodesic distances: ``python -m bench.geodesics``.

On generated bodies, or a manifold mesh: seconds of processor time to prepare it, for the first
source, and for a hundred, one after another, in one process on one thread; the mean and the
greatest relative error against exact distances, and the time for a hundred sources relative to that
of ``graph``.
"""

import time
from dataclasses import asdict, dataclass

import numpy as np
import pygeodesic.geodesic
from threadpoolctl import threadpool_limits

from bench.command_line import command_line, parsed, print_json
from bench.sizes import meshes_by_size, size_options
from solver.arrays import FloatArray, IntArray
from solver.mesh import TriangleMesh, non_manifold_vertices, triangle_mesh
from solver.shape.geodesics import GEODESIC_METHODS, GeodesicMethod, geodesics
from synthetic import human

SIZES = 5_000, 28_000
SOURCES = 100
CHECKED = 10


@dataclass(frozen=True)
class Row:
    """One method on one mesh."""

    vertices: int
    method: GeodesicMethod
    seconds_preparation: float
    seconds_one: float
    seconds_hundred: float
    ratio_to_graph: float
    mean_error: float
    greatest_error: float


def measure(mesh: TriangleMesh) -> list[Row]:
    """Measure all methods on one mesh, one after another."""
    sources = np.random.default_rng(0).permutation(mesh.n_vertices)[:SOURCES].astype(np.int64)
    exact = exact_distances(mesh, sources[:CHECKED])
    rows: list[Row] = []
    for method in GEODESIC_METHODS:
        started = time.process_time()
        measured = geodesics(mesh, method)
        prepared = time.process_time()
        measured.distances(sources[:1])
        first = time.process_time()
        found = measured.distances(sources)
        hundred = time.process_time() - first
        mean, greatest = errors(found[:CHECKED], exact, sources)
        rows.append(
            Row(
                mesh.n_vertices,
                method,
                prepared - started,
                first - prepared,
                hundred,
                hundred / rows[0].seconds_hundred if rows else 1.0,
                mean,
                greatest,
            )
        )
    return rows


def has_exact_distances(mesh: TriangleMesh) -> bool:
    """Whether a mesh is a connected manifold, with or without boundary."""
    edges = mesh.face_edges
    manifold = edges.counts.max() <= 2 and len(non_manifold_vertices(mesh.faces, edges)) == 0
    return bool(manifold) and mesh.components == 1


def exact_distances(mesh: TriangleMesh, sources: IntArray) -> FloatArray:
    """Exact distances from (S,) vertices: (S, V).

    By the algorithm of Mitchell, Mount and Papadimitriou, SIAM J. Comput. 16(4), 1987.

    Parameters
    ----------
    mesh
        With exact distances; pygeodesic crashes on others.
    sources
        (S,) vertices.
    """
    algorithm = pygeodesic.geodesic.PyGeodesicAlgorithmExact(mesh.vertices, mesh.faces)
    return np.array([algorithm.geodesicDistances(np.array([source]))[0] for source in sources])


def errors(found: FloatArray, exact: FloatArray, sources: IntArray) -> tuple[float, float]:
    """Mean and greatest relative error, without the sources themselves."""
    apart = np.ones(exact.shape, dtype=np.bool_)
    apart[np.arange(len(exact)), sources[: len(exact)]] = False
    relative = np.abs(found[apart] / exact[apart] - 1.0)
    return float(relative.mean()), float(relative.max())


def main() -> None:
    """Measure and print a table."""
    parser = command_line(__doc__)
    size_options(parser, SIZES)
    arguments = parsed(parser)
    meshes = meshes_by_size(parser, arguments, SIZES)
    if not all(map(has_exact_distances, meshes)):
        parser.error("--mesh is not a connected manifold: exact distances cannot be computed")
    small = human(resolution=500)
    measure(triangle_mesh(small.vertices, small.faces))  # compiles
    print(
        f"{'vertices':>9} {'method':14}{'prepare s':>10}{'one s':>9}{'hundred s':>11}"
        f"{'of graph':>10}{'mean error':>12}{'greatest':>10}"
    )
    rows: list[Row] = []
    with threadpool_limits(1):
        for mesh in meshes:
            for row in measure(mesh):
                rows.append(row)
                print(
                    f"{row.vertices:9} {row.method:14}{row.seconds_preparation:10.3f}"
                    f"{row.seconds_one:9.4f}{row.seconds_hundred:11.2f}{row.ratio_to_graph:10.1f}"
                    f"{row.mean_error:12.3%}{row.greatest_error:10.2%}",
                    flush=True,
                )
    print_json(arguments, [asdict(row) for row in rows])


if __name__ == "__main__":
    main()
