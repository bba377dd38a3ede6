"""Signatures of the shapes of a collection: from the cache, or computed and cached."""

from broker.contracts import (
    DissimilaritiesPayload,
    DissimilarityParameters,
    ShapeRecord,
    spectrum_key,
)
from broker.store import Store
from solver.control import Control
from solver.errors import OptionError
from solver.shape import Shape
from solver.similarity import Signature, SimilarityOptions, signature
from worker.jobs.context import JobContext
from worker.jobs.failures import ShapeGone, UnusableShape, attributed_to
from worker.jobs.meshes import mesh_of, spectrum_key_of
from worker.jobs.options import options_of
from worker.jobs.spectra import spectrum_of


def cached_signatures(payload: DissimilaritiesPayload, store: Store) -> dict[int, bytes]:
    """Return the cached signatures that this tenant has used before, by their shapes' places.

    Raises
    ------
    ShapeGone
        A shape was deleted.
    """
    records = store.shapes.records(payload.shapes)
    names = [
        _name(record, shape, payload.parameters)
        for record, shape in zip(records, payload.shapes, strict=True)
    ]
    points = payload.parameters.points
    places = [place for place, known in enumerate(store.spectra.known(names)) if known]
    found = store.spectra.get_many([names[place] for place in places])
    return {
        place: data
        for place, data in zip(places, found, strict=True)
        if data is not None and _suits(data, points)
    }


def compute_signature(
    payload: DissimilaritiesPayload, place: int, context: JobContext, control: Control
) -> bytes:
    """Return the signature of a shape: cached by a job of another tenant, or computed.

    Parameters
    ----------
    payload
        The collection and its parameters.
    place
        Place of the shape in the collection.
    context
        Of the time slice that computes it.
    control
        Cancellation of the whole job.

    Raises
    ------
    UnusableShape
        The shape cannot be compared.
    ShapeGone
        The shape was deleted.
    OptionError
        A parameter does not fit it.
    Cancelled
        Through `control`.
    """
    shape, parameters, spectra = payload.shapes[place], payload.parameters, context.store.spectra
    key = spectrum_key_of(parameters, shape, context.store.shapes)
    cached = spectra.get(parameters.signature_name(key))
    if cached is not None and _suits(cached, parameters.points):
        return cached
    field = f"shapes.{place}"
    try:
        with attributed_to(field):
            mesh = mesh_of(key, shape, context.store)
            spectrum = spectrum_of(key, mesh, spectra, context.runner, control)
            solid = Shape(mesh, spectrum, eigenpairs=parameters.eigenpairs)
            found = signature(solid, options_of(SimilarityOptions, parameters)).to_bytes()
    except OptionError as error:
        if error.field == "points":
            raise UnusableShape(field, error.message) from error
        raise
    spectra.put(parameters.signature_name(key), found)
    return found


def _name(record: ShapeRecord | None, shape: str, parameters: DissimilarityParameters) -> str:
    if record is None:
        raise ShapeGone(shape)
    return parameters.signature_name(spectrum_key(parameters, record))


def _suits(data: bytes, points: int) -> bool:
    try:
        return Signature.from_bytes(data).points >= points
    except ValueError:
        return False
