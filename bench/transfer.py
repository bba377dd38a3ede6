"""Values carried along dense maps: ``python -m bench.transfer``.

Per pair of shapes of a class with known truth: the share of the target's area whose carried segment
is the true one, in both directions; and what a smooth function loses there and back, relative to
its standard deviation. The same for segments of faces: the share of the target's area, and what
there and back leaves. Segments are the geodesic Voronoi cells of points spread over the source, the
farthest first: ends of limbs, and what is between them.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from bench.collection import KnownShape, known_pairs, pair_options
from bench.command_line import command_line, parsed, print_json
from solver.arrays import BoolArray, FloatArray, IntArray
from solver.matching import MatchOptions, match
from solver.mesh import TriangleMesh, triangle_areas
from solver.registration import DenseCorrespondence
from solver.shape import farthest_point_sampling
from solver.transfer import FACES, PullBack, overlap_of

SEGMENTS = 8
"""Segments of a shape: head, hands and feet of a body, and what is between them."""

FUNCTION = 6
"""Eigenfunctions whose sum is the smooth function."""


@dataclass(frozen=True)
class Carried:
    """Figures of one pair.

    Parameters
    ----------
    forwards, backwards
        Share of the area whose segment is the true one, of source and of target segments.
    loss
        Root mean square error of a smooth function there and back, over its standard deviation.
    uncovered
        Share of the target's vertices that no source vertex is mapped to.
    faces
        Share of the area whose segment is the true one, where segments are of faces.
    faces_back
        Share of the source's area that has its segment again, there and back.
    """

    forwards: float
    backwards: float
    loss: float
    uncovered: float
    faces: float
    faces_back: float


def segments_of(known: KnownShape, count: int = SEGMENTS) -> IntArray:
    """(V,) cell of each vertex: the nearest of `count` farthest points along the surface."""
    nearest: IntArray = _distances(known, count).argmin(axis=0)
    return nearest


def _distances(known: KnownShape, count: int) -> FloatArray:
    """(count, V) geodesic distances of vertices from farthest points."""
    metric = known.shape.metric("geodesic")
    return metric.distances(farthest_point_sampling(metric, count).indices)


def area_share(
    source: KnownShape, target: KnownShape, labels: IntArray, carried: IntArray
) -> float:
    """Share of the target's area, at vertices of known truth, that has the true label.

    Parameters
    ----------
    source, target
        Shapes of one class with known truth.
    labels, carried
        (V,) labels of the source's vertices, and (W,) those of the target's.
    """
    assert source.truth is not None
    assert target.truth is not None
    known = (source.truth >= 0) & (target.truth >= 0)
    vertices, first = np.unique(target.truth[known], return_index=True)
    true = labels[source.truth[known][first]]
    areas = target.shape.spectrum().mass[vertices]
    return float(areas[carried[vertices] == true].sum() / areas.sum())


def judged(
    source: KnownShape, target: KnownShape, dense: DenseCorrespondence, segments: int = SEGMENTS
) -> Carried:
    """Carry segments and a smooth function along a map, and compare with the truth."""
    assert dense.inverse is not None
    there = PullBack.along(dense.inverse, target.shape.mesh)
    back = PullBack.along(dense, source.shape.mesh)
    return Carried(
        _agreement(source, target, there, segments),
        _agreement(target, source, back, segments),
        _loss(source, there, back),
        1.0 - len(np.unique(dense.target)) / len(dense.inverse.source),
        *_of_faces(source, target, dense, segments),
    )


def _agreement(source: KnownShape, target: KnownShape, along: PullBack, segments: int) -> float:
    labels = segments_of(source, segments)
    by_file = _by_file(source, labels, -1)
    carried = along.spread(along.majority(by_file), -1)[target.shape.mesh.vertex_ids]
    return area_share(source, target, labels, carried)


def _of_faces(
    source: KnownShape, target: KnownShape, dense: DenseCorrespondence, segments: int
) -> tuple[float, float]:
    """Shares of the target's area with the true segment, and of the source's with its own again."""
    assert dense.inverse is not None
    here, there = source.shape.mesh, target.shape.mesh
    distances = _distances(source, segments)
    labels = distances[:, here.faces].sum(axis=2).argmin(axis=0)
    true = distances[:, _true_vertices(source, target)[there.faces]].sum(axis=2).argmin(axis=0)
    forth = overlap_of(there, dense.inverse, here, FACES, FACES)
    carried = forth.spread(forth.majority(_rows_of_faces(here, labels)), -1)
    back = overlap_of(here, dense, there, FACES, FACES)
    again = back.spread(back.majority(carried), -1)
    return (
        _share(there, carried[there.face_ids] == true),
        _share(here, again[here.face_ids] == labels),
    )


def _true_vertices(source: KnownShape, target: KnownShape) -> IntArray:
    """(W,) the source's vertex at each of the target's, or at the nearest of known truth."""
    assert source.truth is not None
    assert target.truth is not None
    known = (source.truth >= 0) & (target.truth >= 0)
    vertices = target.shape.mesh.vertices
    nearest = KDTree(vertices[target.truth[known]]).query(vertices)[1]
    found: IntArray = source.truth[known][nearest]
    return found


def _rows_of_faces(mesh: TriangleMesh, labels: IntArray) -> IntArray:
    assert mesh.face_ids is not None
    assert mesh.file_rows is not None
    rows = np.full(mesh.file_rows[1], -1)
    rows[mesh.face_ids] = labels
    return rows


def _share(mesh: TriangleMesh, right: BoolArray) -> float:
    return float(triangle_areas(mesh.vertices, mesh.faces)[right].sum() / mesh.area)


def _loss(source: KnownShape, there: PullBack, back: PullBack) -> float:
    spectrum = source.shape.spectrum()
    smooth: FloatArray = spectrum.eigenfunctions[:, 1 : 1 + FUNCTION].sum(axis=1)
    carried = there.spread(there.means(_by_file(source, smooth, 0.0)), 0.0)
    returned = back.spread(back.means(carried), 0.0)[source.shape.mesh.vertex_ids]
    area = spectrum.mass / spectrum.mass.sum()
    error = np.sqrt((area * (returned - smooth) ** 2).sum())
    spread = np.sqrt((area * (smooth - (area * smooth).sum()) ** 2).sum())
    return float(error / spread)


def _by_file(known: KnownShape, values: np.ndarray, missing: float) -> np.ndarray:
    ids, own = known.shape.mesh.numbering
    rows = np.full(known.shape.mesh.vertex_rows, missing, dtype=values.dtype)
    rows[ids] = values[own]
    return rows


def main() -> None:
    """Carry values along the maps of the pairs, print a table."""
    parser = command_line(__doc__, data=True)
    pair_options(parser, classes=1)
    parser.add_argument("--segments", type=int, default=SEGMENTS, help="segments of a shape")
    arguments = parsed(parser)
    pairs = known_pairs(parser, arguments)
    heads = "forwards", "backwards", "loss", "uncovered", "faces", "faces_back"
    print(f"{'pair':40}" + "".join(f"{head:>11}" for head in heads))
    rows = []
    for source, target in pairs:
        found = match(source.shape, target.shape, MatchOptions(dense=True))
        assert found.dense is not None
        carried = judged(source, target, found.dense, arguments.segments)
        row = [getattr(carried, head) for head in heads]
        rows.append(row)
        name = f"{source.name} {target.name}"
        print(f"{name:40}" + "".join(f"{one:11.4f}" for one in row), flush=True)
    table = np.array(rows)
    figures = {
        "pairs": len(rows),
        "segment_area": float(table[:, :2].mean()),
        "least_segment_area": float(table[:, :2].min()),
        "loss_there_and_back": float(table[:, 2].mean()),
        "uncovered_by_source": float(table[:, 3].mean()),
        "face_segment_area": float(table[:, 4].mean()),
        "least_face_segment_area": float(table[:, 4].min()),
        "face_segment_area_there_and_back": float(table[:, 5].mean()),
    }
    print("\n" + "   ".join(f"{name} {value:.4g}" for name, value in figures.items()))
    print_json(arguments, figures)


if __name__ == "__main__":
    main()
