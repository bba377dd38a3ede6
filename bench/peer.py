"""Time and error of a dense pair beside pyFM: ``python -m bench.peer``.

The peer is the recipe of the README of pyFM (``pip install pyfmaps``, 1.3): wave kernel signatures,
a functional map of 30 eigenfunctions that preserves orientation, 16 steps of ZoomOut. Both read the
same files, compute spectra and map all vertices of the source, in turn, in one process, on one
thread; times are processor times. The peer is no part of the requirements.

``--large`` compares our own time at 50,000 vertices with that at 5,000 instead.
"""

import importlib
import importlib.util
import time
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from threadpoolctl import threadpool_limits

from bench.collection import Pair, known_pairs, pair_options
from bench.command_line import command_line, parsed, print_json
from bench.map_error import WRONG, map_error, vertex_errors
from bench.robust import changed, simplified_to
from solver.arrays import IntArray
from solver.matching import MatchOptions, match
from solver.mesh import TriangleMesh, read_mesh, triangle_mesh
from solver.shape import Shape
from synthetic import subdivided

SMALL, LARGE = 5_000, 50_000
"""Numbers of vertices that times are compared at."""

_COMPARED_LARGE = 100
"""Known points compared on large meshes, where distances take long."""


@dataclass(frozen=True)
class Run:
    """Seconds of one dense pair, and its mean direct error over √area, at vertices and between."""

    seconds: float
    error: float
    error_at_vertices: float


def write_pair(pair: Pair, folder: Path) -> tuple[Path, Path]:
    """Write both meshes as OFF files, with all digits."""
    paths = folder / "source.off", folder / "target.off"
    for path, one in zip(paths, pair, strict=True):
        mesh = one.shape.mesh
        vertices = "\n".join(" ".join(map(repr, row)) for row in mesh.vertices.tolist())
        faces = "\n".join(f"3 {a} {b} {c}" for a, b, c in mesh.faces.tolist())
        path.write_text(f"OFF\n{mesh.n_vertices} {mesh.n_faces} 0\n{vertices}\n{faces}\n")
    return paths


def run_ours(pair: Pair, compared: int = 500) -> Run:
    """Read, compute spectra, map all vertices."""
    with TemporaryDirectory() as folder:
        paths = write_pair(pair, Path(folder))
        started = time.process_time()
        shapes = [Shape(read_mesh(path.read_bytes(), "off")) for path in paths]
        found = match(shapes[0], shapes[1], MatchOptions(dense=True))
        seconds = time.process_time() - started
    assert found.dense is not None
    source, target = (replace(one, shape=s) for one, s in zip(pair, shapes, strict=True))
    error = map_error(source, target, found.dense, compared)
    return Run(seconds, error.direct, error.at_vertices)


def run_peer(pair: Pair) -> Run:
    """Do the same with pyFM, as its README says."""
    with TemporaryDirectory() as folder:
        source, target = write_pair(pair, Path(folder))
        started = time.process_time()
        images = peer_map(source, target)
        seconds = time.process_time() - started
    error = float(vertex_errors(*pair, images).mean())
    return Run(seconds, error, error)


def peer_map(source: Path, target: Path) -> IntArray:
    """(V,) vertices of the target for all of the source, by the README of pyFM 1.3.

    Its maps lead from its second mesh to its first.
    """
    meshes = importlib.import_module("pyFM.mesh")
    functional = importlib.import_module("pyFM.functional")
    first, second = (
        meshes.TriMesh.load(str(path), area_normalize=True, center=True)
        for path in (target, source)
    )
    model = functional.FunctionalMapping(first, second)
    model.preprocess(descr_type="WKS", subsample_step=2)
    model.fit(K=30, w_descr=1e0, w_lap=1e-1, w_dcomm=1e0, w_orient=1e0)
    return np.asarray(model.get_p2p(model.zoomout_refine(nit=16, step=5)), dtype=np.int64)


def beside_the_peer(pairs: list[Pair]) -> dict[str, float]:
    """Run both on all pairs in turn, print a table, return the figures."""
    heads = "ours s", "pyFM s", "ratio", "ours", "vertices", "pyFM"
    print(f"{'pair':40}" + "".join(f"{head:>10}" for head in heads))
    ours, theirs = [], []
    for pair in pairs:
        ours.append(run_ours(pair))
        theirs.append(run_peer(pair))
        a, b = ours[-1], theirs[-1]
        values = a.seconds, b.seconds, a.seconds / b.seconds, a.error, a.error_at_vertices, b.error
        name = f"{pair[0].name} {pair[1].name}"
        print(f"{name:40}" + "".join(f"{value:10.4f}" for value in values), flush=True)
    seconds = np.array([[a.seconds, b.seconds] for a, b in zip(ours, theirs, strict=True)])
    errors = np.array([[a.error, b.error] for a, b in zip(ours, theirs, strict=True)])
    return {
        "pairs": len(pairs),
        "ratio": float(np.median(seconds[:, 0] / seconds[:, 1])),
        "seconds_ours": float(np.median(seconds[:, 0])),
        "seconds_peer": float(np.median(seconds[:, 1])),
        "error_ours": float(errors[:, 0].mean()),
        "error_ours_at_vertices": float(np.mean([one.error_at_vertices for one in ours])),
        "error_peer": float(errors[:, 1].mean()),
        "wrong_ours": float((errors[:, 0] > WRONG).mean()),
        "wrong_peer": float((errors[:, 1] > WRONG).mean()),
    }


def by_size(pairs: list[Pair]) -> dict[str, float]:
    """Time our own maps of small and large versions of all pairs, print a table."""
    print(f"{'pair':40}{'vertices':>10}{'s':>10}{'error':>10}")
    seconds = []
    for pair in pairs:
        row = []
        for change in (_small, _large):
            sized = changed(pair[0], change), changed(pair[1], change)
            found = run_ours(sized, _COMPARED_LARGE)
            row.append(found.seconds)
            vertices = sized[0].shape.n_vertices
            name = f"{pair[0].name} {pair[1].name}"
            print(f"{name:40}{vertices:10}{found.seconds:10.2f}{found.error:10.4f}", flush=True)
        seconds.append(row)
    small, large = np.array(seconds).T
    return {
        "pairs": len(pairs),
        "seconds_small": float(np.median(small)),
        "seconds_large": float(np.median(large)),
        "large_over_small": float(np.median(large / small)),
    }


def _small(mesh: TriangleMesh) -> tuple[TriangleMesh, IntArray]:
    return simplified_to(mesh, SMALL)


def _large(mesh: TriangleMesh) -> tuple[TriangleMesh, IntArray]:
    """Simplified, then subdivided twice, which multiplies vertices by about 16."""
    coarse, image = simplified_to(mesh, LARGE // 16)
    vertices, faces = coarse.vertices, coarse.faces
    for _ in range(2):
        vertices, faces = subdivided(vertices, faces)
    return triangle_mesh(vertices, faces), image


def main() -> None:
    """Time the pairs, print a table."""
    parser = command_line(__doc__, data=True)
    pair_options(parser, classes=1, every=2)
    parser.add_argument("--large", action="store_true", help="compare sizes, without the peer")
    arguments = parsed(parser)
    if not arguments.large and importlib.util.find_spec("pyFM") is None:
        raise SystemExit(
            "bench.peer runs pyFM, which is not installed: `pip install pyfmaps` into the "
            "environment that runs this, or leave it out with --large"
        )
    pairs = known_pairs(parser, arguments, SMALL)
    with threadpool_limits(1):
        run_ours(pairs[0])  # compiles
        figures = by_size(pairs) if arguments.large else beside_the_peer(pairs)
    print("\n" + "   ".join(f"{name} {value:.4g}" for name, value in figures.items()))
    print_json(arguments, figures)


if __name__ == "__main__":
    main()
