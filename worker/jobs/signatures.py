"""Signatures of the shapes of a collection: from the cache, or computed and cached."""

from broker.contracts import (
    DissimilaritiesPayload,
    DissimilarityParameters,
    ShapeRecord,
    spectrum_key,
)
from broker.store import Store
from solver.control import Control
from solver.errors import MeshError, OptionError
from solver.shape import Shape
from solver.similarity import Signature, SimilarityOptions, signature
from worker.jobs.failures import ShapeGone, UnusableShape
from worker.jobs.meshes import mesh_from_bytes, mesh_of
from worker.jobs.options import options_of
from worker.jobs.spectra import spectrum_of


def cached_signatures(payload: DissimilaritiesPayload, store: Store) -> dict[int, bytes]:
    """Return the signatures that are known already, by the places of their shapes.

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
    found = enumerate(store.spectra.signatures(names))
    return {place: data for place, data in found if data is not None and _suits(data, points)}


def compute_signature(
    payload: DissimilaritiesPayload, place: int, store: Store, holder: str, control: Control
) -> bytes:
    """Compute the signature of a shape, and cache it.

    Parameters
    ----------
    payload
        What is to be compared, and how.
    place
        Which of the shapes it is.
    store
        Where the shape and its spectrum are.
    holder, control
        See :func:`worker.jobs.spectra.spectrum_of`.

    Raises
    ------
    UnusableShape
        The shape cannot be compared.
    ShapeGone
        It was deleted.
    OptionError
        A parameter has no meaning for it.
    Cancelled
        Through `control`.
    """
    shape, parameters = payload.shapes[place], payload.parameters
    stored = store.shapes.mesh(shape)
    if stored is None:
        raise ShapeGone(shape)
    whole = mesh_from_bytes(stored)
    key = spectrum_key(parameters, shape, whole.n_vertices, whole.components)
    try:
        if whole.components > 1 and not key.largest_component:
            raise MeshError(f"it has {whole.components} components; ask for `largest_component`")
        mesh = mesh_of(key, whole, store.spectra)
        spectrum = spectrum_of(key, mesh, store.spectra, holder, control)
        solid = Shape(mesh, spectrum, eigenpairs=parameters.eigenpairs)
        found = signature(solid, options_of(SimilarityOptions, parameters)).to_bytes()
    except MeshError as error:
        raise UnusableShape(f"shapes.{place}", str(error)) from error
    except OptionError as error:
        if error.field == "points":
            raise UnusableShape(f"shapes.{place}", error.message) from error
        raise
    store.spectra.put(parameters.signature_name(key), found)
    return found


def _name(record: ShapeRecord | None, shape: str, parameters: DissimilarityParameters) -> str:
    if record is None:
        raise ShapeGone(shape)
    key = spectrum_key(parameters, shape, record.vertices, record.components)
    return parameters.signature_name(key)


def _suits(data: bytes, points: int) -> bool:
    try:
        return Signature.from_bytes(data).points >= points
    except ValueError:
        return False
