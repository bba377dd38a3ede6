"""A shape X with its structures: a metric d_X and a descriptor f_X, section 2."""

from functools import cached_property

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.descriptors import (
    DESCRIPTORS,
    heat_kernel_signature,
    scale_invariant_heat_kernel_signature,
)
from solver.errors import MeshError, OptionError
from solver.geodesics import GeodesicGraph
from solver.mesh import TriangleMesh
from solver.metrics import METRICS, CommuteTimeMetric, DiffusionMetric, GeodesicMetric, Metric
from solver.sampling import FarthestPointSampling, farthest_point_sampling
from solver.spectrum import Spectrum, laplace_beltrami_spectrum

DEFAULT_EIGENPAIRS = 100
"""Eigenpairs that spectral metrics and descriptors are made of."""

DEFAULT_DIFFUSION_TIME = 0.01
"""t of (3), meant for a surface of unit area."""


class Shape:
    """A connected mesh and what is computed on it, each once, when first asked for.

    Lengths are divided by √area unless `normalise` is false, so that thresholds and weights mean
    the same on every shape.

    Parameters
    ----------
    mesh
        A connected mesh, in the user's units.
    spectrum
        Spectrum of the mesh *scaled to unit area*, what :meth:`spectrum` of a normalised shape
        returns, if it is known already (from a cache); computed when needed otherwise.
    normalise
        Whether lengths are divided by √area. If not, they are in the user's units, and so are
        diffusion times, in units of length².
    eigenpairs
        Number of eigenpairs that spectral metrics and descriptors use, the constant included.

    Raises
    ------
    MeshError
        The mesh has several components.
    OptionError
        `eigenpairs` is less than 2.
    """

    def __init__(
        self,
        mesh: TriangleMesh,
        spectrum: Spectrum | None = None,
        *,
        normalise: bool = True,
        eigenpairs: int = DEFAULT_EIGENPAIRS,
    ) -> None:
        if mesh.components > 1:
            raise MeshError(
                f"the mesh has {mesh.components} components and distances between them are "
                "infinite; match its largest component instead, or join them"
            )
        if eigenpairs < 2:
            raise OptionError("eigenpairs", "at least 2 are needed")
        if spectrum is not None and len(spectrum.mass) != mesh.n_vertices:
            raise ValueError("the spectrum is that of another mesh")
        self.mesh = mesh
        self.normalise = normalise
        self.eigenpairs = eigenpairs
        self._unit_spectrum = spectrum
        self._metrics: dict[tuple[str, float | None], Metric] = {}
        self._samplings: dict[tuple[str, float | None], FarthestPointSampling] = {}

    @property
    def n_vertices(self) -> int:
        """Number V of vertices."""
        return self.mesh.n_vertices

    @cached_property
    def unit(self) -> float:
        """The user's length that is 1 here: √area, or 1 for a shape that is not normalised."""
        return float(np.sqrt(self.mesh.area)) if self.normalise else 1.0

    @cached_property
    def surface(self) -> TriangleMesh:
        """The mesh on which everything is computed: centred, and of unit area if normalised."""
        return self.mesh.scaled(1.0 / self.unit)

    def spectrum(self, k: int | None = None) -> Spectrum:
        """Spectrum of the Laplace-Beltrami operator of `surface`.

        Parameters
        ----------
        k
            Number of eigenpairs, `eigenpairs` by default. A small mesh may have fewer.
        """
        k = min(self.eigenpairs if k is None else k, self.n_vertices)
        if self._unit_spectrum is None or self._unit_spectrum.n_eigenpairs < k:
            unit_surface = self.mesh.scaled(1.0 / np.sqrt(self.mesh.area))
            self._unit_spectrum = laplace_beltrami_spectrum(unit_surface, k)
        spectrum = self._unit_spectrum.truncated(k)
        return spectrum if self.normalise else spectrum.scaled(float(np.sqrt(self.mesh.area)))

    def metric(self, name: str, diffusion_time: float | None = None) -> Metric:
        """Metric d_X.

        Parameters
        ----------
        name
            One of `METRICS`.
        diffusion_time
            t of (3), in the square of this shape's unit of length: in units of its area if it is
            normalised. 0.01 by default. Only for "diffusion".

        Raises
        ------
        OptionError
            The name is unknown, or the time not positive.
        """
        if name not in METRICS:
            raise OptionError("metric", f"{name!r} is none of {', '.join(METRICS)}")
        key = (name, diffusion_time if name == "diffusion" else None)
        if key not in self._metrics:
            self._metrics[key] = self._new_metric(name, diffusion_time)
        return self._metrics[key]

    def descriptor(self, name: str, vertices: IntArray | None = None) -> FloatArray:
        """Local descriptor f_X.

        Parameters
        ----------
        name
            One of `DESCRIPTORS`.
        vertices
            (S,) where it is wanted; by default at all V vertices.

        Returns
        -------
        (S, m) float64

        Raises
        ------
        OptionError
            The name is unknown.
        """
        if name == "hks":
            return heat_kernel_signature(self.spectrum(), vertices=vertices)
        if name == "si_hks":
            return scale_invariant_heat_kernel_signature(self.spectrum(), vertices=vertices)
        raise OptionError("descriptor", f"{name!r} is none of {', '.join(DESCRIPTORS)}")

    def sampling(
        self, metric_name: str, count: int, diffusion_time: float | None = None
    ) -> FarthestPointSampling:
        """Farthest point sampling in a metric.

        Parameters
        ----------
        metric_name, diffusion_time
            As for :meth:`metric`.
        count
            Number of samples. The longest sampling so far is kept; shorter ones are its beginning.

        Raises
        ------
        OptionError
            The metric is unknown, or the shape has fewer vertices.
        """
        metric = self.metric(metric_name, diffusion_time)
        key = (metric_name, diffusion_time if metric_name == "diffusion" else None)
        known = self._samplings.get(key)
        if known is None or len(known) < count:
            known = self._samplings[key] = farthest_point_sampling(metric, count)
        return known.first(count)

    @cached_property
    def _geodesics(self) -> GeodesicMetric:
        return GeodesicMetric(GeodesicGraph(self.surface))

    def _new_metric(self, name: str, diffusion_time: float | None) -> Metric:
        if name == "geodesic":
            return self._geodesics
        if name == "commute_time":
            return CommuteTimeMetric(self.spectrum())
        if diffusion_time is None:
            diffusion_time = DEFAULT_DIFFUSION_TIME
        if not 0.0 < diffusion_time < np.inf:
            raise OptionError("diffusion_time", "it must be positive and finite")
        return DiffusionMetric(self.spectrum(), diffusion_time)
