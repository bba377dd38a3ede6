"""Transfers along a match: of attribute files, of the shape's own attributes, and of landmarks."""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from broker.contracts import (
    LANDMARKS,
    TEXTURE,
    UV,
    AttributeElement,
    AttributesRecord,
    AttributeSummary,
    AttributesValidationPayload,
    Confidence,
    DenseCorrespondence,
    InverseCorrespondence,
    SurfacePoint,
    TransferPayload,
    TransferResult,
)
from broker.store import Store
from solver import registration, transfer
from solver.arrays import FloatArray
from solver.control import Control
from solver.errors import MeshError, OptionError, TransferError
from solver.mesh import TriangleMesh
from solver.mesh.formats import mesh_in_zip
from solver.mesh.textures import Paint
from solver.transfer import (
    COLORS,
    COLORS_NAME,
    FACES,
    VERTICES,
    Attribute,
    Landmarks,
    PullBack,
)
from solver.transfer.attributes import Along
from solver.transfer.files import read_attributes, write_npz
from worker.jobs.attribute_rows import with_rows_known
from worker.jobs.context import JobContext
from worker.jobs.failures import AttributesGone, ResultGone, ShapeGone, UploadGone
from worker.jobs.match_results import result_from_blob
from worker.jobs.meshes import stored_mesh
from worker.jobs.textures import carried_paint, corner_attributes, texture_of

CHANNELS: Final = ("red", "green", "blue")
"""Columns of colours."""

_NAMED: Final = 10
"""Missing landmarks that a warning names."""

_ON: Final[dict[str, AttributeElement]] = {VERTICES: "vertices", FACES: "faces"}


def validate_attributes(payload: AttributesValidationPayload, context: JobContext) -> None:
    """Store the attribute file of a job's upload.

    Raises
    ------
    TransferError
        The upload is not a usable attribute file.
    UploadGone
        The upload has expired.
    """
    store, job = context.store, context.record
    data = store.uploads.candidate(payload.attributes, payload.file_type, job.id)
    if data is None:
        # Either the job is repeated after it has stored the file, or the upload has expired.
        if store.attributes.get(payload.attributes) is None:
            raise UploadGone
        return
    found = read_attributes(data, payload.file_type)
    record = AttributesRecord(
        id=payload.attributes,
        name=payload.name,
        file_type=payload.file_type,
        bytes=len(data),
        rows=len(found[0].values),
        attributes=tuple(map(summary_of, found)),
        created=job.created,
    )
    store.attributes.add(record, data, job.id)


def carry(payload: TransferPayload, context: JobContext) -> bytes:
    """Carry attributes or landmarks along a match, store the arrays and return the document.

    Raises
    ------
    ResultGone, ShapeGone, AttributesGone
        The match's result, a shape or the attribute file expired or was deleted.
    OptionError, TransferError
        The attributes cannot be carried.
    Cancelled
        Through the reporter.
    """
    start = time.perf_counter()
    store, control = context.store, context.reporter.control()
    control.report("reading the match", 0.0)
    packed = store.results.document(payload.match)
    if packed is None:
        raise ResultGone("the result of the match has expired; match again")
    match = result_from_blob(packed)
    dense, forwards = match.dense, payload.direction == "source_to_target"
    # By the direction: source and target may be one shape, of two names.
    names = (match.source_name, match.target_name)[:: 1 if forwards else -1]
    if dense is None or dense.inverse is None:
        raise OptionError("match", "it has no map in both directions; match again with `dense`")
    found = _outcome(payload, dense, dense.inverse, context, control)
    carried, points = found.attributes, found.points
    # The map of an alternative is not that of the answer, which confidence is of.
    confidence = match.confidence if dense.hypothesis == 0 else None
    store.results.set_arrays(context.record.id, write_arrays(carried, points))
    return (
        TransferResult(
            match=payload.match,
            source=payload.source,
            target=payload.target,
            source_name=names[0],
            target_name=names[1],
            what=payload.what,
            direction=payload.direction,
            on=_on(carried, payload),
            rows=len(carried[0].values) if carried else 0,
            attributes=tuple(map(summary_of, carried)),
            points=points,
            confidence=confidence,
            warnings=(*_in_doubt(confidence), *found.warnings),
            timings={"total": time.perf_counter() - start},
        )
        .model_dump_json()
        .encode()
    )


@dataclass(frozen=True, eq=False)
class _Outcome:
    """Carried attributes, or the images of landmarks."""

    attributes: tuple[Attribute, ...] = ()
    points: tuple[SurfacePoint | None, ...] | None = None
    warnings: tuple[str, ...] = ()


def _outcome(
    payload: TransferPayload,
    dense: DenseCorrespondence,
    inverse: InverseCorrespondence,
    context: JobContext,
    control: Control,
) -> _Outcome:
    shapes, forwards = context.store.shapes, payload.direction == "source_to_target"
    if payload.what == LANDMARKS:
        control.report("mapping the landmarks", 0.5)
        along = solver_map(dense, inverse, forwards=forwards)
        points = _images(payload.points, along, stored_mesh(payload.target, shapes))
        return _Outcome(points=points, warnings=_without_image(points))
    # Each vertex takes the value at its image, so the map goes the other way.
    back = solver_map(dense, inverse, forwards=not forwards)
    if payload.what == TEXTURE:
        control.report("sampling the texture", 0.5)
        pixels = PullBack.along(back)
        colors = _texture_colors(payload, back, pixels, context.store)
        return _Outcome((colors,), warnings=_without_value(colors, pixels))
    if payload.what == UV:
        control.report("mapping the texture coordinates", 0.5)
        target = stored_mesh(payload.target, shapes)
        paint = carried_paint(payload.source, target, back, shapes)
        return _Outcome(corner_attributes(target, paint), warnings=_without_coordinates(paint))
    control.report("carrying the values", 0.5)
    source, target = stored_mesh(payload.source, shapes), stored_mesh(payload.target, shapes)
    asked = transfer.selected(_attributes(payload, context), payload.what, payload.names)
    chosen = with_rows_known(asked, source, payload)
    onto = payload.on or _shared([one.on for one in chosen])
    if onto == FACES and target.is_cloud:
        # As `on` is left out: the service refuses faces of a point cloud.
        message = 'the values are of faces, which a point cloud has not; give "vertices"'
        raise OptionError("on", message)
    kind, influences = payload.what, payload.influences
    ways: dict[str, Along] = {}
    carried = []
    for one in chosen:
        of = one.on or VERTICES
        if of not in ways:
            pointwise = FACES not in (onto, of)
            ways[of] = (
                PullBack.along(back)
                if pointwise
                else transfer.overlap_of(target, back, source, onto, of)
            )
        carried.append(transfer.carried(one, kind, ways[of], influences, onto))
    return _Outcome(tuple(carried), warnings=_without_value(carried[-1], ways[of]))


def _shared(on: Sequence[str | None]) -> str:
    """Faces if all attributes are of faces, else vertices."""
    return FACES if set(on) == {FACES} else VERTICES


def summary_of(attribute: Attribute) -> AttributeSummary:
    """Return the description of an attribute."""
    kinds: dict[str, Literal["number", "integer", "text"]] = {"U": "text", "i": "integer"}
    return AttributeSummary(
        name=attribute.name,
        type=kinds.get(attribute.values.dtype.kind, "number"),
        columns=attribute.columns or tuple(map(str, range(attribute.width))),
        on=_ON.get(attribute.on or ""),
        rows=len(attribute.values),
    )


def solver_map(
    dense: DenseCorrespondence, inverse: InverseCorrespondence, *, forwards: bool
) -> registration.DenseCorrespondence:
    """Return one direction of a stored map, as the solver takes it."""
    first, second = (dense.source, dense.target) if forwards else (inverse.target, inverse.source)
    one = dense if forwards else inverse
    return registration.DenseCorrespondence(
        np.array(first, dtype=np.int64),
        np.array(second, dtype=np.int64),
        np.array(one.faces, dtype=np.int64).reshape(-1, 3),
        np.array(one.barycentric, dtype=np.float64).reshape(-1, 3),
    )


def colors_of_file(mesh: TriangleMesh, colors: FloatArray) -> Attribute:
    """Return (V, 3) colours of a mesh by the vertex numbers of its file."""
    ids, own = mesh.numbering
    rows = np.zeros((int(ids[-1]) + 1, 3))
    rows[ids] = colors[own]
    return Attribute(COLORS_NAME, rows, CHANNELS)


def write_arrays(
    attributes: Sequence[Attribute], points: Sequence[SurfacePoint | None] | None = None
) -> bytes:
    """Return attributes, or landmarks as `vertices` and `weights`, as the bytes of an ``.npz``.

    Landmarks without an image have -1 and nan.
    """
    if points is not None:
        vertices = [3 * (-1,) if one is None else one.vertices for one in points]
        weights = [3 * (np.nan,) if one is None else one.weights for one in points]
        attributes = (
            Attribute("vertices", np.array(vertices, dtype=np.int64)),
            Attribute("weights", np.array(weights)),
        )
    return write_npz(attributes)


def _attributes(payload: TransferPayload, context: JobContext) -> tuple[Attribute, ...]:
    """Attributes of the uploaded file, or of the shape's own."""
    store = context.store
    if payload.attributes is not None:
        record = store.attributes.use(payload.attributes)
        file = store.attributes.file(payload.attributes)
        if record is None or file is None:
            raise AttributesGone(payload.attributes)
        return read_attributes(file, record.file_type)
    mesh = stored_mesh(payload.source, store.shapes)
    if payload.what == COLORS:
        return (_own_colors(mesh),)
    shape, data = store.shapes.get(payload.source), store.shapes.upload(payload.source)
    if shape is None or data is None:
        raise ShapeGone(payload.source)
    try:
        inside = mesh_in_zip(data) if shape.file_type == "zip" else (shape.file_type, data)
        return read_attributes(inside[1], inside[0])
    except (MeshError, TransferError) as error:
        message = f"the shape's own file has none ({error}); upload a file of attributes"
        raise OptionError("attributes", message) from error


def _on(
    carried: Sequence[Attribute], payload: TransferPayload
) -> Literal["vertices", "faces", "corners"]:
    if payload.what == UV:
        return "corners"
    return "faces" if carried and carried[0].on == FACES else "vertices"


def _texture_colors(
    payload: TransferPayload,
    back: registration.DenseCorrespondence,
    along: PullBack,
    store: Store,
) -> Attribute:
    surface, paint = texture_of(payload.source, store.shapes)
    vertices = Landmarks(
        np.repeat(back.source[:, None], 3, axis=1), np.tile([1.0, 0.0, 0.0], (len(back.source), 1))
    )
    colors = along.spread(transfer.texture_colors(vertices, back, surface, paint), np.nan)
    return Attribute(COLORS_NAME, colors, CHANNELS)


def _own_colors(mesh: TriangleMesh) -> Attribute:
    """Colours of a shape, which are those of its texture if it has one."""
    if mesh.colors is None:
        raise OptionError("attributes", "the shape has no colours; upload a file of attributes")
    return colors_of_file(mesh, mesh.colors)


def _images(
    points: Sequence[SurfacePoint],
    dense: registration.DenseCorrespondence,
    target: TriangleMesh,
) -> tuple[SurfacePoint | None, ...]:
    """Images of landmarks; None for those with a corner that the map does not have."""
    corners = np.array([one.vertices for one in points], dtype=np.int64)
    mapped = np.isin(corners, dense.source).all(axis=1)
    images: list[SurfacePoint | None] = [None] * len(points)
    if not mapped.any():
        return tuple(images)
    weights = np.array([one.weights for one in points])
    try:
        found = transfer.landmark_images(Landmarks(corners[mapped], weights[mapped]), dense, target)
    except TransferError as error:
        raise OptionError("points", str(error)) from error
    shares = found.barycentric.clip(0.0, 1.0)
    for place, three, share in zip(np.flatnonzero(mapped), found.corners, shares, strict=True):
        images[place] = SurfacePoint(vertices=tuple(three.tolist()), weights=tuple(share.tolist()))
    return tuple(images)


def _in_doubt(confidence: Confidence | None) -> tuple[str, ...]:
    """Warn of values that may be carried to wrong places."""
    if confidence is None or not confidence.in_doubt:
        return ()
    return ("the match is in doubt: what it carries may lie in wrong places",)


def _without_image(points: Sequence[SurfacePoint | None]) -> tuple[str, ...]:
    """Which landmarks are missing, and why, if some are."""
    missing = [str(place) for place, one in enumerate(points) if one is None]
    if not missing:
        return ()
    more = f" and {len(missing) - _NAMED} more" if len(missing) > _NAMED else ""
    return (
        f"{len(missing)} of {len(points)} landmarks are missing, as they have no partner or are not"
        f" part of the mapped surface: points {', '.join(missing[:_NAMED])}{more}, counted from 0",
    )


def _without_value(carried: Attribute, along: Along) -> tuple[str, ...]:
    """How many rows have no value, and why, if some have none."""
    of, rows = carried.on or VERTICES, len(carried.values)
    warnings = []
    if outside := rows - len(along.reached):
        warnings.append(f"{outside} {of} of the file are not part of the mapped surface")
    if carried.values.dtype.kind == "f":
        reached = carried.values[along.reached].reshape(len(along.reached), -1)
        if unknown := int(np.isnan(reached).any(axis=1).sum()):
            warnings.append(f"{unknown} {of} have no value: what they correspond to has none")
    return tuple(warnings)


def _without_coordinates(paint: Paint) -> tuple[str, ...]:
    count = 3 * int((paint.texture_of_face < 0).sum())
    return (f"{count} corners of triangles have no texture coordinates",) if count else ()
