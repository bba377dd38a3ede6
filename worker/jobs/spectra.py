"""Spectra, computed once: from the cache, from whoever computes them just now, or here."""

import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Final

from broker.contracts import SPECTRUM_VERSION, SpectrumKey
from broker.processes import memory_left
from broker.store import Spectra
from broker.telemetry import logger
from solver.control import Control
from solver.mesh import TriangleMesh
from solver.prototype import ExampleSurface, SurfaceSpectra
from solver.shape import Shape
from solver.shape.laplacian import Spectrum, spectrum_memory
from worker.jobs.failures import TooLarge

LEASE: Final = 20.0
"""Seconds after which a holder that no longer renews its lock counts as dead."""

_RENEWAL: Final = LEASE / 5
_POLL: Final = 0.05

log = logger("isomatch.spectra")


def spectrum_of(
    key: SpectrumKey, mesh: TriangleMesh, spectra: Spectra, holder: str, control: Control
) -> Spectrum:
    """Return the spectrum of a mesh of unit area, computing it only if nobody has or does.

    Parameters
    ----------
    key
        Name of the spectrum.
    mesh
        The connected mesh that `key` names.
    spectra
        The cache.
    holder
        Who computes it if it comes to that.
    control
        Asked while somebody else computes it.

    Raises
    ------
    MeshError
        The spectrum cannot be computed.
    TooLarge
        It takes more memory than there is.
    Cancelled
        The caller of the computation asked to stop.
    """
    while True:
        known = _cached(key, spectra)
        if known is not None:
            spectra.count_hit()
            return known
        if spectra.lock(key, holder, LEASE):
            # Whoever held the lock before may just have finished.
            known = _cached(key, spectra)
            if known is not None:
                spectra.release(key, holder)
                spectra.count_hit()
                return known
            with _lease(key, spectra, holder):
                return _compute(key, mesh, spectra)
        while spectra.locked(key):
            control.check()
            time.sleep(_POLL)


def surface_spectra(
    prototype: str, surfaces: Sequence[ExampleSurface], spectra: Spectra
) -> SurfaceSpectra:
    """Spectra of a prototype's surfaces, kept in the cache: later matches need not compute them.

    Whoever finds one missing computes it; that takes less time than to wait for others.

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
    # Whoever finds it in the cache finds it counted, and told of.
    spectra.count_computed()
    seconds = round(time.perf_counter() - start, 3)
    log.info("spectrum computed", spectrum=str(key), vertices=mesh.n_vertices, seconds=seconds)
    spectra.put(key, spectrum.to_bytes())
    return spectrum


@contextmanager
def _lease(key: SpectrumKey, spectra: Spectra, holder: str) -> Iterator[None]:
    done = threading.Event()

    def renew() -> None:
        while not done.wait(_RENEWAL):
            spectra.renew(key, holder, LEASE)

    thread = threading.Thread(target=renew, daemon=True)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()
        spectra.release(key, holder)
