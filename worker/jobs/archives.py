"""Archives of prototypes: whether one that was uploaded is sound, and what is shown of it."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime
from typing import Any, Final

import numpy as np
from pydantic import ValidationError

from broker.contracts import (
    GREATEST,
    JobRecord,
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
from worker.jobs.failures import PrototypeGone, UploadGone
from worker.jobs.structures import choice_of
from worker.jobs.torus import torus_file
from worker.pictures import packed_prototype

_MOST_WARNINGS: Final = 300
_LONGEST_WARNING: Final = 300


def validate(payload: PrototypeValidationPayload, job: JobRecord, store: Store) -> None:
    """Make a prototype of a job's candidate.

    Raises
    ------
    PrototypeError
        It is none.
    UploadGone
        There is nothing to be read any more.
    """
    prototypes = store.prototypes
    data = prototypes.candidate(payload.prototype, payload.file_type, job.id)
    if data is None:
        # This is a repetition of what succeeded, or the upload waited for too long.
        if prototypes.get(payload.prototype) is None:
            raise UploadGone
        return
    prototype = prototype_from_bytes(data)
    _check(prototype)
    record = record_of(prototype, data, payload.name, job.created)
    prototypes.add(record, data, packed_prototype(prototype), job.id)


def _check(prototype: Prototype) -> None:
    """Refuse what can be read and would end matches in numbers without meaning.

    Raises
    ------
    PrototypeError
        Something in it is too large, or not of the form its structures have.
    """
    numbers = [prototype.positions, *(level.mixtures.means for level in prototype.distances)]
    described = [level for level in prototype.descriptors if level is not None]
    for surface in prototype.surfaces:
        numbers += [surface.vertices, surface.eigenvalues]
    for level in described:
        numbers += [level.centre, level.axes, level.mixtures.means]
    if any(np.abs(array).max(initial=0.0) > GREATEST for array in numbers):
        raise PrototypeError(f"not a sound prototype: it has numbers beyond {GREATEST:g}")
    mixtures = [level.mixtures for level in prototype.distances]
    mixtures += [level.mixtures for level in described]
    if not all(map(_peaks, mixtures)):
        raise PrototypeError("not a sound prototype: a distribution is too narrow for any number")
    for place, surface in enumerate(prototype.surfaces):
        try:
            surface.mesh()
        except MeshError as error:
            raise PrototypeError(f"not a sound prototype: surface{place}: {error}") from error
    shape = Shape(read_mesh(torus_file(), "off"), eigenpairs=prototype.eigenpairs)
    for level in described:
        usual = shape.descriptor(level.descriptor, np.zeros(1, dtype=np.int64)).shape[1]
        if usual != len(level.centre):
            raise PrototypeError(
                f"not a sound prototype: {level.descriptor.name} has {usual} values at a point,"
                f" and {len(level.centre)} were learned"
            )


def _peaks(mixtures: GaussianMixtures) -> bool:
    """Whether the greatest densities, which costs are relative to, can be computed."""
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
        It was deleted.
    """
    archive = store.prototypes.archive(prototype)
    if archive is None:
        raise PrototypeGone(prototype)
    found = prototype_from_bytes(archive)
    return replace(found, warnings=_readable(found.warnings))


def _readable(warnings: Sequence[str]) -> tuple[str, ...]:
    """Warnings of an archive that anybody may have written, fit to be shown."""
    lines = ("".join(filter(str.isprintable, warning)) for warning in warnings[:_MOST_WARNINGS])
    return tuple(line[:_LONGEST_WARNING] for line in lines)


def record_of(
    prototype: Prototype, archive: bytes, name: str, created: datetime
) -> PrototypeRecord:
    """Return what is shown of a prototype.

    Parameters
    ----------
    prototype, archive
        The prototype, also as bytes.
    name
        What it is to be called; the version is given when it is stored.
    created
        When it was asked for.

    Raises
    ------
    PrototypeError
        It is made of something that cannot be asked for.
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
        warnings=_readable(prototype.warnings),
        created=created,
    )
