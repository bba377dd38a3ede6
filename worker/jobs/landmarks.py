"""Landmarks of a transfer: placed on their surface, carried along a match, and measured."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from broker.contracts import (
    SurfacePoint,
    TransferPayload,
    TransferredLandmark,
    TransferredPoint,
)
from solver import transfer
from solver.arrays import FloatArray
from solver.errors import OptionError, TransferError
from solver.mesh import TriangleMesh
from solver.registration import DenseCorrespondence
from solver.transfer import Attribute, Landmarks
from solver.transfer.files import write_npz

_NAMED: Final = 10
"""Things of one kind that a warning names."""


@dataclass(frozen=True, eq=False)
class LandmarkMap:
    """The match that landmarks are carried along.

    Parameters
    ----------
    maps
        From the source of the transfer to its target, and back.
    source, target
        Their surfaces.
    scale
        Factor from lengths of the source to lengths of the target; None if it is that of their
        √area.
    probability
        Confidence of the match; nan if it is not known.
    """

    maps: tuple[DenseCorrespondence, DenseCorrespondence]
    source: TriangleMesh
    target: TriangleMesh
    scale: float | None
    probability: float


def carried_landmarks(
    payload: TransferPayload, along: LandmarkMap
) -> tuple[tuple[TransferredLandmark, ...], tuple[str, ...]]:
    """Return the landmarks of a transfer on its target, and warnings.

    Raises
    ------
    MisplacedLandmarks
        All are far from the source's surface, or they are in another coordinate system.
    OptionError
        Barycentric coordinates of points are wrong.
    """
    labels, points, from_surface, remarks = _given(payload, along.source)
    try:
        found = transfer.carry_landmarks(
            points, along.maps, along.source, along.target, along.scale
        )
    except TransferError as error:
        raise OptionError("points", str(error)) from error
    sure = transfer.landmark_confidence(along.probability, found.round_trip, found.distortion)
    here, there = _points(points, along.source), _points(found.images, along.target)
    measures = map(_known, (sure, found.round_trip, found.distortion, from_surface))
    landmarks = tuple(
        TransferredLandmark(
            label=label,
            on_source=start,
            position=image and image.position,
            vertices=image and image.vertices,
            weights=image and image.weights,
            confidence=confidence,
            round_trip=trip,
            distortion=change,
            from_surface=apart,
        )
        for label, start, image, confidence, trip, change, apart in zip(
            labels, here, there, *measures, strict=True
        )
    )
    return landmarks, (*remarks, *_without_image(payload, landmarks))


def image_of(landmark: TransferredLandmark) -> TransferredPoint | None:
    """Return the image of a landmark, None if it has none."""
    if landmark.vertices is None or landmark.weights is None:
        return None
    return TransferredPoint(
        vertices=landmark.vertices, weights=landmark.weights, position=landmark.position
    )


def point_arrays(points: Sequence[SurfacePoint | None]) -> tuple[Attribute, ...]:
    """Return `vertices` (n, 3) int64 and `weights` (n, 3); -1 and nan where there is no point."""
    vertices = [3 * (-1,) if one is None else one.vertices for one in points]
    weights = [3 * (np.nan,) if one is None else one.weights for one in points]
    return (
        Attribute("vertices", np.array(vertices, dtype=np.int64)),
        Attribute("weights", np.array(weights)),
    )


def landmark_arrays(landmarks: Sequence[TransferredLandmark]) -> bytes:
    """Return landmarks as the bytes of an ``.npz``.

    Besides those of :func:`point_arrays`: `labels` (n,), empty texts for none; `positions` (n, 3)
    and `confidence`, `round_trip`, `distortion` and `from_surface` (n,) float64, nan for what is
    null in the document.
    """

    def column(name: str) -> Attribute:
        values = [getattr(one, name) for one in landmarks]
        return Attribute(name, np.array(values, dtype=np.float64))

    positions = [one.position or 3 * (np.nan,) for one in landmarks]
    return write_npz(
        (
            *point_arrays([image_of(one) for one in landmarks]),
            Attribute("labels", np.array([one.label or "" for one in landmarks], dtype=np.str_)),
            Attribute("positions", np.array(positions)),
            *map(column, ("confidence", "round_trip", "distortion", "from_surface")),
        )
    )


def _given(
    payload: TransferPayload, source: TriangleMesh
) -> tuple[Sequence[str | None], Landmarks, FloatArray, tuple[str, ...]]:
    """Labels of landmarks, their points, distances from the given positions, and remarks."""
    if payload.points is not None:
        points = Landmarks(
            np.array([one.vertices for one in payload.points], dtype=np.int64),
            np.array([one.weights for one in payload.points]),
        )
        count = len(payload.points)
        return count * (None,), points, np.full(count, np.nan), ()
    labels = [one.label for one in payload.landmarks]
    positions = [one.position or 3 * (np.nan,) for one in payload.landmarks]
    placed = transfer.place_landmarks(labels, np.array(positions), source)
    return labels, placed.points, placed.from_surface, placed.remarks


def _points(points: Landmarks, mesh: TriangleMesh) -> list[TransferredPoint | None]:
    shares = points.barycentric.clip(0.0, 1.0)
    positions = Landmarks(points.corners, shares).positions(mesh)
    rows = zip(points.corners.tolist(), shares.tolist(), positions.tolist(), strict=True)
    return [
        None
        if np.isnan(position[0])
        else TransferredPoint(
            vertices=tuple(corners), weights=tuple(weights), position=tuple(position)
        )
        for corners, weights, position in rows
    ]


def _known(values: FloatArray) -> list[float | None]:
    return [None if np.isnan(value) else value for value in values.tolist()]


def _without_image(
    payload: TransferPayload, landmarks: Sequence[TransferredLandmark]
) -> tuple[str, ...]:
    """Which landmarks have no image, and why, if some of those on the surface have none."""
    on_surface = payload.points is not None
    missing = [
        str(place) if on_surface else transfer.landmark_name(place, one.label)
        for place, one in enumerate(landmarks)
        if one.position is None and (on_surface or one.on_source is not None)
    ]
    if not missing:
        return ()
    named = f"points {some_of(missing)}, counted from 0" if on_surface else some_of(missing)
    return (
        f"{len(missing)} of {len(landmarks)} landmarks are missing, as they have no partner or are"
        f" not part of the mapped surface: {named}",
    )


def some_of(names: Sequence[str]) -> str:
    """Return the first of some names, and how many more there are."""
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return ", ".join(names[:_NAMED]) + more
