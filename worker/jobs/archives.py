"""Archives of prototypes: validation of uploaded ones, and their records."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime
from typing import Any, Final

import numpy as np
from pydantic import ValidationError

from broker.contracts import (
    PrototypeRecord,
    PrototypeStructures,
    PrototypeValidationPayload,
    prototype_id,
)
from broker.store import Store
from solver.errors import MeshError, PrototypeError
from solver.mesh import read_mesh
from solver.prototype import Prototype, prototype_from_bytes
from solver.prototype.mixtures import GaussianMixtures
from solver.shape import Shape
from solver.shape.choices import NoDescriptor
from worker.jobs.context import JobContext
from worker.jobs.failures import PrototypeGone
from worker.jobs.options import choice_of
from worker.jobs.torus import torus_file
from worker.jobs.uploads import stored_once
from worker.pictures import packed_prototype, prototype_view

_GREATEST: Final = 1e64
"""Greatest number of an archive: the largest extent of a mesh, so that what was learned of any can
be read again. The fourth power is still finite."""

_MAX_WARNINGS: Final = 300
"""Warnings of an uploaded archive that are kept."""

_MAX_WARNING_LENGTH: Final = 300
"""Characters of each that are kept."""


def validate_prototype(payload: PrototypeValidationPayload, context: JobContext) -> None:
    """Store the prototype of a job's upload.

    Raises
    ------
    PrototypeError
        The upload is not a valid prototype.
    UploadGone
        The upload has expired.
    """
    prototypes, job = context.store.prototypes, context.record
    with stored_once(prototypes, payload.prototype):
        data = context.store.uploads.candidate(payload.prototype, payload.file_type, job.id)
        prototype = prototype_from_bytes(data)
        _check(prototype)
        record = record_of(prototype, data, payload.name, job.created)
        prototypes.add(record, data, packed_prototype(prototype), job.id)


def _check(prototype: Prototype) -> None:
    """Refuse a readable prototype whose matches would not be finite numbers.

    Raises
    ------
    PrototypeError
        A number is too large, or an array does not fit its structure.
    """
    numbers = [prototype.positions, *(level.mixtures.means for level in prototype.distances)]
    described = [level for level in prototype.descriptors if level is not None]
    for surface in prototype.surfaces:
        numbers += [surface.vertices, surface.eigenvalues]
    for level in described:
        numbers += [level.centre, level.axes, level.mixtures.means]
    if any(np.abs(array).max(initial=0.0) > _GREATEST for array in numbers):
        raise PrototypeError(f"not a sound prototype: it has numbers beyond {_GREATEST:g}")
    mixtures = [level.mixtures for level in prototype.distances]
    mixtures += [level.mixtures for level in described]
    if not all(map(_has_finite_peaks, mixtures)):
        raise PrototypeError("not a sound prototype: a distribution is too narrow for any number")
    for place, surface in enumerate(prototype.surfaces):
        try:
            surface.mesh()
        except MeshError as error:
            raise PrototypeError(f"not a sound prototype: surface{place}: {error}") from error
    shape = Shape(read_mesh(torus_file(), "off"), eigenpairs=prototype.eigenpairs)
    for level in described:
        size = shape.descriptor(level.descriptor, np.zeros(1, dtype=np.int64)).shape[1]
        if size != len(level.centre):
            raise PrototypeError(
                f"not a sound prototype: {level.descriptor.name} has {size} values at a point,"
                f" and {len(level.centre)} were learned"
            )


def _has_finite_peaks(mixtures: GaussianMixtures) -> bool:
    """Return whether the greatest densities, to which costs are relative, are finite."""
    with np.errstate(all="ignore"):
        try:
            return bool(np.isfinite(mixtures.log_peaks).all())
        except np.linalg.LinAlgError:
            return False


def stored_prototype(store: Store, prototype: str) -> Prototype:
    """Return a prototype.

    Raises
    ------
    PrototypeGone
        The prototype was deleted.
    """
    archive = store.prototypes.archive(prototype)
    if archive is None:
        raise PrototypeGone(prototype)
    found = prototype_from_bytes(archive)
    return replace(found, warnings=_sanitised(found.warnings))


def _sanitised(warnings: Sequence[str]) -> tuple[str, ...]:
    """Warnings of an untrusted archive: limited, without control characters."""
    lines = ("".join(filter(str.isprintable, warning)) for warning in warnings[:_MAX_WARNINGS])
    return tuple(line[:_MAX_WARNING_LENGTH] for line in lines)


def record_of(
    prototype: Prototype, archive: bytes, name: str, created: datetime
) -> PrototypeRecord:
    """Return the record of a prototype.

    Parameters
    ----------
    prototype, archive
        The prototype, also as bytes.
    name
        Its name; the version is set when it is stored.
    created
        Time of the job.

    Raises
    ------
    PrototypeError
        A structure is not one of the contract's.
    """
    values: dict[str, Any] = {
        "metric": tuple(choice_of(level.metric) for level in prototype.distances),
        "descriptor": tuple(
            choice_of(NoDescriptor() if level is None else level.descriptor)
            for level in prototype.descriptors
        ),
        "sampling": tuple(map(choice_of, prototype.sampling)),
        "eigenpairs": prototype.eigenpairs,
        "geodesic_method": prototype.geodesic_method,
        "normalise": prototype.normalise,
    }
    try:
        parameters = PrototypeStructures.model_validate(values)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise PrototypeError(f"not a sound prototype: {where}: {first['msg']}") from error
    return PrototypeRecord(
        id=prototype_id(archive),
        name=name,
        version=1,
        bytes=len(archive),
        points=prototype.points,
        components=prototype.components,
        examples=prototype.examples,
        parameters=parameters,
        surfaces=len(prototype.surfaces),
        learned_from=None,
        reference=None,
        view=prototype_view(prototype).rows(),
        warnings=_sanitised(prototype.warnings),
        created=created,
    )
