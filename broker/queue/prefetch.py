"""The spectra a job will need, so that workers compute them before it begins."""

from collections.abc import Collection
from typing import TypeAlias

from broker.contracts import (
    ConsistentMapsPayload,
    JobRecord,
    MatchPayload,
    PrototypePayload,
    RegistrationPayload,
    SpectrumKey,
    is_prototype,
    spectrum_key,
    subject_of,
)
from broker.store import Shapes, Store

SpectralPayload: TypeAlias = (
    MatchPayload | PrototypePayload | RegistrationPayload | ConsistentMapsPayload
)
"""Payload of a job that uses spectra of its shapes."""


def wanted_spectra(payload: SpectralPayload, shapes: Shapes) -> list[SpectrumKey]:
    """Return the keys of the spectra that a job will use, each once.

    Parameters
    ----------
    payload
        The job.
    shapes
        The stored shapes; those that are deleted have no spectrum.
    """
    if not payload.needs_spectrum:
        return []
    wanted = [shape for shape in subject_of(payload).shapes if not is_prototype(shape)]
    parameters = payload.parameters
    return [
        spectrum_key(parameters, shape) for shape in shapes.records(wanted) if shape is not None
    ]


def needed_by_others(
    record: JobRecord, keys: Collection[SpectrumKey], store: Store
) -> set[SpectrumKey]:
    """Return which of these spectra a live job other than `record` will use.

    Those of a batch's matches are not prefetched.
    """
    needed = set[SpectrumKey]()
    for other in store.jobs.active_of({key.shape for key in keys}):
        if other.id != record.id and isinstance(other.payload, SpectralPayload):
            needed.update(wanted_spectra(other.payload, store.shapes))
    return needed.intersection(keys)
