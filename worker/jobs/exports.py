"""Results as files of other formats: CSV tables, and surfaces as PLY, OBJ and GLB."""

import csv
import io
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import PurePath

import numpy as np

from broker.contracts import (
    TEXTURE,
    UV,
    DissimilarityResult,
    MatchResult,
    TransferredLandmark,
    TransferredPoint,
    TransferResult,
)
from broker.store import Store
from solver.transfer import COLORS_NAME, SKINNING, Attribute, PullBack, baked_texture
from solver.transfer.files import (
    WrittenSurface,
    read_attributes,
    write_csv,
    write_glb,
    write_obj_archive,
    write_surface,
    write_textured_glb,
    write_textured_obj,
)
from worker.jobs.carrying import colors_of_file, solver_map
from worker.jobs.failures import ResultGone
from worker.jobs.match_results import result_from_blob
from worker.jobs.meshes import stored_mesh
from worker.jobs.textures import carried_paint, own_textures, texture_of
from worker.pictures import colors_by_place

_APART = 1.2
"""Distance of the two surfaces in one file, in sizes of the larger."""


def export_matrix(result: DissimilarityResult, names: Sequence[str]) -> bytes:
    """Return the matrix of a collection as CSV, with names in the first line and column."""
    header = ["", *names]
    return _table([header, *([name, *row] for name, row in zip(names, result.matrix, strict=True))])


def export_match(result: MatchResult, file_type: str, store: Store) -> bytes:
    """Return the pairs of a match as CSV, or the target in the colours of the source.

    Of GLB both surfaces are in the file, side by side.

    Raises
    ------
    ResultGone
        The result is of a version that gave no map of all vertices in both directions.
    ShapeGone
        A shape was deleted.
    """
    if file_type == "csv":
        pairs = ((one.source, one.target, one.cost) for one in result.correspondences)
        return _table([("source", "target", "cost"), *pairs])
    dense = result.dense
    if dense is None or dense.inverse is None:
        raise ResultGone("the result has no map in both directions; match again")
    source = stored_mesh(result.source, store.shapes)
    target = stored_mesh(result.target, store.shapes)
    along = PullBack.along(solver_map(dense, dense.inverse, forwards=False), target)
    ours = colors_of_file(source, colors_by_place(source.vertices))
    theirs = Attribute(COLORS_NAME, along.spread(along.means(ours.values), 0.0), ours.columns)
    carried = WrittenSurface.of(target, [theirs], "target")
    if file_type != "glb":
        return write_surface(carried, file_type)
    return write_glb([_beside(WrittenSurface.of(source, [ours], "source"), carried), carried])


def export_dense_map(result: MatchResult, pair: tuple[int, int]) -> bytes:
    """Return the map of all vertices of a match as CSV, that of the target for the pair (1, 0).

    Raises
    ------
    ResultGone
        The result has no such map.
    """
    dense = result.dense
    if dense is not None and pair == (0, 1):
        return _table([("source", "target"), *zip(dense.source, dense.target, strict=True)])
    inverse = None if dense is None else dense.inverse
    if inverse is None:
        raise ResultGone("the result has no map of all vertices; match again with `dense`")
    return _table([("source", "target"), *zip(inverse.target, inverse.source, strict=True)])


def export_consistent_map(job_id: str, pair: tuple[int, int], store: Store) -> bytes:
    """Return one of the maps of a collection as CSV.

    Raises
    ------
    ResultGone
        The arrays are no longer kept, or the pair is not mapped.
    """
    stored = store.results.arrays(job_id)
    if stored is None:
        raise ResultGone("the result has expired")
    with np.load(io.BytesIO(stored), allow_pickle=False) as arrays:
        name = "map_{}_{}".format(*pair)
        if name not in arrays:
            raise ResultGone("the shapes were not mapped")
        images = arrays[name]
    mapped = np.flatnonzero(images >= 0)
    rows = zip(mapped.tolist(), images[mapped].tolist(), strict=True)
    return _table([("source", "target"), *rows])


def export_transfer(result: TransferResult, job_id: str, file_type: str, store: Store) -> bytes:
    """Return carried attributes as CSV, or with the surface that they were carried to.

    Raises
    ------
    ResultGone, ShapeGone
        The arrays or the shape are no longer kept.
    TransferError
        The format cannot hold an attribute.
    """
    if result.points is not None:
        return _landmark_table(result.points, result.landmarks)
    painted = result.what in (TEXTURE, UV)
    if (painted and file_type in ("glb", "zip")) or (result.what, file_type) == (UV, "obj"):
        return _textured(result, file_type, store)
    arrays = store.results.arrays(job_id)
    if arrays is None:
        raise ResultGone("the result has expired")
    attributes = read_attributes(arrays, "npz")
    # The archive has no names of columns but those of joints, and others for names of its own.
    named = tuple(
        replace(one, name=known.name, columns=known.columns, on=result.on)
        for one, known in zip(attributes, result.attributes, strict=True)
    )
    if file_type == "csv":
        return write_csv(named)
    if (result.what, file_type) == (SKINNING, "glb"):
        return write_glb([_skinned(result, named, store)], mipmaps=True)
    mesh = stored_mesh(result.target, store.shapes)
    surface = WrittenSurface.of(mesh, named, _stem(result))
    return write_surface(surface, file_type)


def _landmark_table(
    points: Sequence[TransferredPoint | None], landmarks: Sequence[TransferredLandmark] | None
) -> bytes:
    """Return images of landmarks and their confidences; empty cells for what is unknown."""
    header = ("vertex1", "vertex2", "vertex3", "weight1", "weight2", "weight3")
    missing = len(header) * ("",)
    # Results of earlier versions have images alone.
    sure = [None] * len(points) if landmarks is None else [one.confidence for one in landmarks]
    rows = (
        (*(missing if one is None else (*one.vertices, *one.weights)), own)
        for one, own in zip(points, sure, strict=True)
    )
    return _table([(*header, "confidence"), *rows])


def _skinned(result: TransferResult, weights: Sequence[Attribute], store: Store) -> WrittenSurface:
    """Return the target with joints, and with the textures or the colours that it has itself."""
    own = own_textures(result.target, store.shapes)
    if own is not None:
        mesh, paint = own
        return replace(WrittenSurface.of(mesh, weights, _stem(result)), paint=paint)
    mesh = stored_mesh(result.target, store.shapes)
    colors = () if mesh.colors is None else (colors_of_file(mesh, mesh.colors),)
    return WrittenSurface.of(mesh, [*weights, *colors], _stem(result))


def _textured(result: TransferResult, file_type: str, store: Store) -> bytes:
    """Return the surface with an image or texture coordinates, for which the match is needed."""
    packed = store.results.document(result.match)
    dense = None if packed is None else result_from_blob(packed).dense
    if dense is None or dense.inverse is None:
        raise ResultGone("the result of the match has expired; match again")
    forwards = result.direction == "source_to_target"
    back = solver_map(dense, dense.inverse, forwards=not forwards)
    mesh, name = stored_mesh(result.target, store.shapes), _stem(result)
    if result.what == TEXTURE:
        paint = baked_texture(mesh, back, *texture_of(result.source, store.shapes))
    else:
        paint = carried_paint(result.source, mesh, back, store.shapes)
    if file_type == "glb":
        return write_textured_glb(name, mesh, paint, mipmaps=result.what == UV)
    surface = WrittenSurface.of(mesh, [], name)
    if file_type == "zip":
        return write_obj_archive(surface, paint)
    return write_textured_obj(surface, paint)


def _stem(result: TransferResult) -> str:
    """Return the name of the target without the ending of its file."""
    return PurePath(result.target_name or "").stem or "target"


def _beside(source: WrittenSurface, target: WrittenSurface) -> WrittenSurface:
    """Return the source moved along x, so that it does not overlap with the target."""
    size = max(np.ptp(one.vertices[:, 0]) for one in (source, target))
    ours, theirs = (
        0.5 * (one.vertices.min(axis=0) + one.vertices.max(axis=0)) for one in (source, target)
    )
    shift = theirs - ours - [_APART * size, 0.0, 0.0]
    return WrittenSurface(source.name, source.vertices + shift, source.faces, source.attributes)


def _table(rows: Iterable[Sequence[object]]) -> bytes:
    stream = io.StringIO(newline="")
    csv.writer(stream, lineterminator="\n").writerows(rows)
    return stream.getvalue().encode()
