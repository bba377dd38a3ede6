"""Operations on attribute files, and transfers along a match."""

import operator
from collections.abc import Iterable, Mapping
from typing import Final, SupportsIndex, TypeAlias

import numpy.typing as npt

from isomatch._http import Json, Operation
from isomatch._landmarks import LandmarkSet
from isomatch._models import Attributes, JobRecord, SurfacePoint, is_attributes_id
from isomatch._operations.jobs import start_job
from isomatch._operations.request_parts import Identified, job_id_of, listed
from isomatch._operations.uploads import upload
from isomatch._results import Direction, Element, Match, TransferKind
from isomatch._upload import FileSource, attribute_file
from isomatch._webhooks import Webhook

AttributesSource: TypeAlias = FileSource | Mapping[str, npt.ArrayLike]
"""A path, the bytes of a file, an open binary file, or arrays by name."""

Landmark: TypeAlias = SupportsIndex | SurfacePoint | Mapping[str, object]
"""A vertex, or a point with `vertices` and `weights`."""


LONGEST_LABEL: Final = 200
"""Characters of a label, as in the service."""


def start_transfer(
    match: Identified | Match | str,
    values: Attributes | AttributesSource | None,
    *,
    what: TransferKind,
    direction: Direction,
    on: Element | None,
    names: Iterable[str],
    influences: int | None,
    points: Iterable[Landmark],
    landmarks: LandmarkSet | None,
    webhook: Webhook | None,
    key: str | None,
) -> Operation[JobRecord]:
    """Queue a transfer, of an attribute file that is uploaded first if it is not yet.

    Raises
    ------
    TypeError
        A landmark is neither a vertex nor a point.
    """
    body: dict[str, Json] = {"match": job_id_of(match), "what": what, "direction": direction}
    if isinstance(values, Attributes):
        body["attributes"] = values.id
    elif isinstance(values, str) and is_attributes_id(values):
        body["attributes"] = values
    elif values is not None:
        body["attributes"] = (
            yield from upload(Attributes, "/v1/attributes", attribute_file(values))
        ).id
    if on is not None:
        body["on"] = on
    if named := listed(names, "names"):
        body["names"] = named
    if influences is not None:
        body["influences"] = influences
    if given := [_point(one) for one in listed(points, "landmarks")]:
        body["points"] = given
    if landmarks is not None:
        body["landmarks"] = _in_space(landmarks)
    return (yield from start_job("/v1/transfers", body, {}, webhook, key))


def _in_space(landmarks: LandmarkSet) -> list[Json]:
    rows = zip(landmarks.labels, landmarks.positions.tolist(), landmarks.present, strict=True)
    return [
        {
            # The service calls others by their numbers.
            "label": label if len(label) <= LONGEST_LABEL and label.isprintable() else None,
            "position": position if present else None,
        }
        for label, position, present in rows
    ]


def _point(given: Landmark) -> Json:
    if isinstance(given, SurfacePoint):
        return {"vertices": list(given.vertices), "weights": list(given.weights)}
    if isinstance(given, Mapping):
        return given
    try:
        return operator.index(given)  # `int` would make a vertex of 0.5, too
    except TypeError:
        form = "a vertex, or a point with `vertices` and `weights`"
        raise TypeError(f"give each landmark as {form}, not {given!r:.60}") from None
