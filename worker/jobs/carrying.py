"""What a transfer carries: attributes of a file or of the shape, or images of landmarks."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from broker.contracts import (
    LANDMARKS,
    TEXTURE,
    UV,
    Confidence,
    DenseCorrespondence,
    InverseCorrespondence,
    Overlap,
    TransferKind,
    TransferPayload,
    TransferredLandmark,
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
    Along,
    Attribute,
    Landmarks,
    PullBack,
)
from solver.transfer.files import read_attributes
from worker.jobs.attribute_rows import with_rows_known
from worker.jobs.context import JobContext
from worker.jobs.failures import AttributesGone, ShapeGone, content_of
from worker.jobs.landmarks import LandmarkMap, carried_landmarks, some_of
from worker.jobs.meshes import stored_mesh
from worker.jobs.textures import carried_paint, corner_attributes, texture_of

CHANNELS: Final = ("red", "green", "blue")
"""Columns of colours."""


@dataclass(frozen=True, eq=False)
class TransferRequest:
    """What to carry, along which map.

    Parameters
    ----------
    payload
        Of the job.
    dense, inverse
        The map of the match, and that of the target's vertices.
    confidence, overlap
        Of the match; None if it has none.
    context
        Of the job.
    control
        Reports progress and cancels.
    """

    payload: TransferPayload
    dense: DenseCorrespondence
    inverse: InverseCorrespondence
    confidence: Confidence | None
    overlap: Overlap | None
    context: JobContext
    control: Control

    @property
    def store(self) -> Store:
        """The store of the job."""
        return self.context.store

    def source(self) -> TriangleMesh:
        """Return the mesh that is carried from."""
        return stored_mesh(self.payload.source, self.store.shapes)

    def target(self) -> TriangleMesh:
        """Return the mesh that is carried to."""
        return stored_mesh(self.payload.target, self.store.shapes)

    def along(self) -> registration.DenseCorrespondence:
        """Return the map in the direction of the transfer."""
        return solver_map(self.dense, self.inverse, forwards=self._is_forwards)

    def back(self) -> registration.DenseCorrespondence:
        """Return the map against it: each vertex takes the value at its image."""
        return solver_map(self.dense, self.inverse, forwards=not self._is_forwards)

    def scale(self) -> float | None:
        """Return the factor from lengths of the source to those of the target, if one is a part."""
        if self.overlap is None:
            return None
        return self.overlap.scale if self._is_forwards else 1.0 / self.overlap.scale

    @property
    def _is_forwards(self) -> bool:
        return self.payload.direction == "source_to_target"


@dataclass(frozen=True, eq=False)
class Carried:
    """Carried attributes, or the images of landmarks."""

    attributes: tuple[Attribute, ...] = ()
    landmarks: tuple[TransferredLandmark, ...] | None = None
    warnings: tuple[str, ...] = ()


def carried_by(request: TransferRequest) -> Carried:
    """Carry what is asked for.

    Raises
    ------
    ShapeGone, AttributesGone
        A shape or the attribute file expired or was deleted.
    OptionError, TransferError
        The attributes cannot be carried.
    Cancelled
        Through the control.
    """
    return _CARRIERS.get(request.payload.what, _carry_values)(request)


def carried_from(
    payload: TransferPayload, source: TriangleMesh, store: Store
) -> tuple[Attribute, ...]:
    """Return the attributes that a transfer carries, as they are on its source.

    Raises
    ------
    ShapeGone, AttributesGone
        The shape or the attribute file expired or was deleted.
    OptionError, TransferError
        There are no such attributes.
    """
    asked = transfer.selected(_attributes(payload, store), payload.what, payload.names)
    return with_rows_known(asked, source, payload)


def _carry_landmarks(request: TransferRequest) -> Carried:
    request.control.report("mapping the landmarks", 0.5)
    probability = np.nan if request.confidence is None else request.confidence.probability
    along = LandmarkMap(
        (request.along(), request.back()),
        request.source(),
        request.target(),
        request.scale(),
        probability,
    )
    landmarks, warnings = carried_landmarks(request.payload, along)
    return Carried(landmarks=landmarks, warnings=warnings)


def _carry_texture(request: TransferRequest) -> Carried:
    request.control.report("sampling the texture", 0.5)
    back = request.back()
    pixels = PullBack.along(back, request.target())
    colors = _texture_colors(request.payload, back, pixels, request.store)
    return Carried((colors,), warnings=rows_without_value([colors], [pixels]))


def _carry_texture_coordinates(request: TransferRequest) -> Carried:
    request.control.report("mapping the texture coordinates", 0.5)
    target = request.target()
    paint = carried_paint(request.payload.source, target, request.back(), request.store.shapes)
    return Carried(corner_attributes(target, paint), warnings=_without_coordinates(paint))


def _carry_values(request: TransferRequest) -> Carried:
    request.control.report("carrying the values", 0.5)
    payload, back = request.payload, request.back()
    source, target = request.source(), request.target()
    chosen = carried_from(payload, source, request.store)
    onto = payload.on or _shared([one.on for one in chosen])
    if onto == FACES and target.is_cloud:
        # As `on` is left out: the service refuses faces of a point cloud.
        message = 'the values are of faces, which a point cloud has not; give "vertices"'
        raise OptionError("on", message)
    ways: dict[str, Along] = {}
    for of in dict.fromkeys(one.on or VERTICES for one in chosen):
        pointwise = FACES not in (onto, of)
        ways[of] = (
            PullBack.along(back, target)
            if pointwise
            else transfer.overlap_of(target, back, source, onto, of)
        )
    carried = [
        transfer.carried(one, payload.what, ways[one.on or VERTICES], payload.influences, onto)
        for one in chosen
    ]
    along = [ways[one.on or VERTICES] for one in chosen]
    return Carried(tuple(carried), warnings=rows_without_value(carried, along))


_CARRIERS: Final[Mapping[TransferKind, Callable[[TransferRequest], Carried]]] = {
    LANDMARKS: _carry_landmarks,
    TEXTURE: _carry_texture,
    UV: _carry_texture_coordinates,
}
"""How each kind is carried; those that are left out, as values of vertices or faces."""


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
    rows = np.zeros((mesh.vertex_rows, 3))
    rows[ids] = colors[own]
    return Attribute(COLORS_NAME, rows, CHANNELS)


def _shared(on: Sequence[str | None]) -> str:
    """Faces if all attributes are of faces, else vertices."""
    return FACES if set(on) == {FACES} else VERTICES


def _attributes(payload: TransferPayload, store: Store) -> tuple[Attribute, ...]:
    """Attributes of the uploaded file, or of the shape's own."""
    if payload.attributes is not None:
        record = store.attributes.use(payload.attributes)
        file = store.attributes.file(payload.attributes)
        if record is None or file is None:
            raise AttributesGone(payload.attributes)
        return read_attributes(file, record.file_type)
    mesh = stored_mesh(payload.source, store.shapes)
    if payload.what == COLORS:
        return (_own_colors(mesh),)
    with content_of(payload.source):
        shape, data = store.shapes.get(payload.source), store.shapes.upload(payload.source)
    if shape is None or data is None:
        raise ShapeGone(payload.source)
    try:
        inside = mesh_in_zip(data) if shape.file_type == "zip" else (shape.file_type, data)
        return read_attributes(inside[1], inside[0])
    except (MeshError, TransferError) as error:
        message = f"the shape's own file has none ({error}); upload a file of attributes"
        raise OptionError("attributes", message) from error


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


def rows_without_value(carried: Sequence[Attribute], along: Sequence[Along]) -> tuple[str, ...]:
    """Return how many rows have no value, and why, if some have none.

    Parameters
    ----------
    carried
        Attributes, by the user's numbers.
    along
        The map of each.
    """
    outside: dict[str, None] = {}
    unknown: dict[tuple[int, str], list[str]] = {}
    for one, way in zip(carried, along, strict=True):
        of, values, reached = one.on or VERTICES, one.values, way.reached
        if count := len(values) - len(reached):
            outside[f"{count} {of} of the file are not part of the mapped surface"] = None
        if values.dtype.kind == "f":
            rows = np.isnan(values[reached])
            missing = rows.any(axis=tuple(range(1, rows.ndim)))
            unknown.setdefault((int(missing.sum()), of), []).append(repr(one.name))
    return (
        *outside,
        *(
            f"{count} {of} have no value of {some_of(names)}: what they correspond to has none"
            for (count, of), names in unknown.items()
            if count
        ),
    )


def _without_coordinates(paint: Paint) -> tuple[str, ...]:
    count = 3 * int((paint.texture_of_face < 0).sum())
    return (f"{count} corners of triangles have no texture coordinates",) if count else ()
