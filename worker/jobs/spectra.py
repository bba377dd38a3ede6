"""Spectra, computed once: read from the cache, awaited from another process, or computed here."""

import time
from collections.abc import Callable, Sequence
from typing import Final

from broker.contracts import SPECTRUM_VERSION, SpectrumKey, SpectrumPayload
from broker.processes import memory_left
from broker.store import Spectra
from broker.telemetry import logger
from solver.control import Control
from solver.mesh import TriangleMesh
from solver.prototype import ExampleSurface, SurfaceSpectra
from solver.shape import Shape
from solver.shape.laplacian import Spectrum, spectrum_memory
from worker.jobs.context import JobContext
from worker.jobs.failures import TooLarge
from worker.jobs.meshes import mesh_of

LEASE: Final = 20.0
"""Seconds after which the lock of a process that no longer renews it expires."""

_POLL: Final = 0.05
"""Seconds between two looks at the lock of another process."""

log = logger("isomatch.spectra")


def compute_spectrum(payload: SpectrumPayload, context: JobContext) -> None:
    """Compute a spectrum that later jobs need, unless it is cached or being computed.

    Raises
    ------
    MeshError, TooLarge, ShapeGone, Cancelled
        As for :func:`spectrum_of`; the shape was deleted.
    """
    key, spectra = payload.key, context.store.spectra
    control = context.reporter.control()
    if not spectra.has(key) and not spectra.locked(key):
        control.report("spectrum", 0.0)
        mesh = mesh_of(key, payload.shape, context.store)
        spectrum_of(key, mesh, spectra, context.runner, control)


def spectrum_of(
    key: SpectrumKey, mesh: TriangleMesh, spectra: Spectra, holder: str, control: Control
) -> Spectrum:
    """Return the spectrum of a mesh of unit area, from the cache or computed.

    While one process computes it, others wait for it; what is not cached then, each computes.

    Parameters
    ----------
    key
        Key of the spectrum.
    mesh
        The connected mesh that `key` names.
    spectra
        The cache.
    holder
        Id of the lock's owner if it is computed here.
    control
        Cancellation while another process computes it.

    Raises
    ------
    MeshError
        The spectrum cannot be computed.
    TooLarge
        The computation needs more memory than is left.
    Cancelled
        Through `control`.
    """
    known = _hit(key, spectra)
    if known is not None:
        return known
    if spectra.lock(key, holder, LEASE):
        with spectra.renewed(key, holder, LEASE):
            # The previous owner of the lock may just have finished.
            return _hit(key, spectra) or _compute(key, mesh, spectra)
    while spectra.locked(key):
        control.check()
        time.sleep(_POLL)
    # With the lock, all who need a spectrum that is not kept would compute it one after another.
    return _hit(key, spectra) or _compute(key, mesh, spectra)


def surface_spectra(
    prototype: str, surfaces: Sequence[ExampleSurface], spectra: Spectra
) -> SurfaceSpectra:
    """Return the function that gives the spectra of a prototype's surfaces, cached.

    A missing spectrum is computed without a lock: that takes less time than waiting for another
    process.

    Parameters
    ----------
    prototype
        Id of the prototype.
    surfaces
        All of its surfaces, in their order.
    spectra
        The cache.
    """
    places = {id(surface): place for place, surface in enumerate(surfaces)}

    def spectrum(surface: ExampleSurface, compute: Callable[[], Spectrum]) -> Spectrum:
        name = f"{prototype}:surface{places[id(surface)]}:v{SPECTRUM_VERSION}"
        known = _cached(name, spectra)
        if known is None or len(known.mass) != len(surface.vertices):
            known = compute()
            spectra.put(name, known.to_bytes())
        return known

    return spectrum


def _hit(key: SpectrumKey, spectra: Spectra) -> Spectrum | None:
    known = _cached(key, spectra)
    if known is not None:
        spectra.count_hit()
    return known


def _cached(key: SpectrumKey | str, spectra: Spectra) -> Spectrum | None:
    stored = spectra.get(key)
    if stored is None:
        return None
    try:
        return Spectrum.from_bytes(stored)
    except ValueError as error:
        log.warning("unreadable spectrum in the cache", spectrum=str(key), error=str(error))
        return None


def _compute(key: SpectrumKey, mesh: TriangleMesh, spectra: Spectra) -> Spectrum:
    start = time.perf_counter()
    needed, left = spectrum_memory(mesh.n_vertices, key.eigenpairs), memory_left()
    if needed > left:
        raise TooLarge(mesh.n_vertices, needed, left)
    spectrum = Shape(mesh, eigenpairs=key.eigenpairs).spectrum()
    # Counted and logged before it can be found in the cache.
    spectra.count_computed()
    seconds = round(time.perf_counter() - start, 3)
    log.info("spectrum computed", spectrum=str(key), vertices=mesh.n_vertices, seconds=seconds)
    spectra.put(key, spectrum.to_bytes())
    return spectrum
