"""A shape X with its structures: a metric d_X and a descriptor f_X, section 2."""

from functools import cached_property

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.errors import OptionError
from solver.mesh import TriangleMesh
from solver.shape.choices import (
    Biharmonic,
    CommuteTime,
    ConformalFactor,
    DescriptorChoice,
    Diffusion,
    Eigenfunctions,
    GaussianCurvature,
    Geodesic,
    GeodesicHistogram,
    HeatKernelSignature,
    MetricChoice,
    NoDescriptor,
    Photometric,
    ScaleInvariantHeatKernelSignature,
    WaveKernelSignature,
    descriptor_choice,
    metric_choice,
)
from solver.shape.descriptors import (
    conformal_factor,
    eigenfunction_magnitudes,
    gaussian_curvature,
    geodesic_histogram,
    heat_kernel_signature,
    photometric,
    scale_invariant_heat_kernel_signature,
    wave_kernel_signature,
)
from solver.shape.geodesics import DEFAULT_GEODESIC_METHOD, GEODESIC_METHODS, geodesics
from solver.shape.laplacian import Spectrum, laplace_beltrami_spectrum
from solver.shape.metrics import (
    BiharmonicMetric,
    CommuteTimeMetric,
    DiffusionMetric,
    GeodesicMetric,
    Metric,
)
from solver.shape.sampling import FarthestPointSampling, farthest_point_sampling

DEFAULT_EIGENPAIRS = 100
"""Number of Laplace-Beltrami eigenpairs, the constant one included: h_t of equation (2), truncated
to them, is known to within a percent from t = area / 2⁸ on."""

WITHOUT_COLORS = (
    "the {name} has no vertex colours; choose another descriptor, or upload the shape in a format "
    "that has them, such as PLY, GLB, or OBJ zipped with its materials"
)


class Shape:
    """A mesh with its metrics and descriptors, computed on first use and kept.

    Lengths are divided by √area unless `normalise` is false, so that thresholds and weights mean
    the same on every shape.

    Parameters
    ----------
    mesh
        The mesh, in the user's units. Its links connect its components.
    spectrum
        Spectrum as :meth:`unit_spectrum` returns it, if it is known already; computed when needed
        otherwise.
    normalise
        Divide lengths by √area. Otherwise they are in the user's units, and so are parameters of
        structures that are lengths, areas or times.
    eigenpairs
        Number of eigenpairs that spectral metrics and descriptors use, the constant included.
    geodesic_method
        Method of computing geodesic distances, one of `GEODESIC_METHODS`.

    Raises
    ------
    OptionError
        `eigenpairs` is less than 2, or `geodesic_method` is unknown.
    ValueError
        The spectrum is not that of a mesh with as many vertices.

    Examples
    --------
    >>> import numpy as np
    >>> from solver.mesh import triangle_mesh
    >>> corners = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    >>> mesh = triangle_mesh(corners, np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]))
    >>> shape = Shape(mesh)
    >>> round(shape.surface.area, 12)
    1.0
    >>> shape.metric("geodesic").between(np.array([0, 1])).round(3)
    array([[0.  , 0.76],
           [0.76, 0.  ]])
    >>> shape.sampling("geodesic", 3).indices.shape
    (3,)
    """

    def __init__(
        self,
        mesh: TriangleMesh,
        spectrum: Spectrum | None = None,
        *,
        normalise: bool = True,
        eigenpairs: int = DEFAULT_EIGENPAIRS,
        geodesic_method: str = DEFAULT_GEODESIC_METHOD,
    ) -> None:
        if eigenpairs < 2:
            raise OptionError("eigenpairs", "at least 2 are needed")
        if geodesic_method not in GEODESIC_METHODS:
            known = ", ".join(GEODESIC_METHODS)
            raise OptionError(
                "geodesic_method", f"unknown method {geodesic_method!r}; choose one of {known}"
            )
        if spectrum is not None and len(spectrum.mass) != mesh.n_vertices:
            raise ValueError("the spectrum is that of another mesh, by its number of vertices")
        self.mesh = mesh
        self.normalise = normalise
        self.eigenpairs = eigenpairs
        self.geodesic_method = geodesic_method
        self._unit_spectrum = spectrum
        self._metrics: dict[MetricChoice, Metric] = {}
        self._fields: dict[DescriptorChoice, FloatArray] = {}
        self._samplings: dict[tuple[MetricChoice, tuple[int, ...]], FarthestPointSampling] = {}

    def with_mesh(self, mesh: TriangleMesh, spectrum: Spectrum | None = None) -> "Shape":
        """Return a shape of another mesh, with the options of this one.

        Parameters
        ----------
        mesh
            In the user's units.
        spectrum
            That of this mesh, if it is known.
        """
        return Shape(
            mesh,
            spectrum,
            normalise=self.normalise,
            eigenpairs=self.eigenpairs,
            geodesic_method=self.geodesic_method,
        )

    @property
    def n_vertices(self) -> int:
        """Number V of vertices."""
        return self.mesh.n_vertices

    @cached_property
    def unit(self) -> float:
        """Unit of length of this shape in the user's units: √area, or 1 if not normalised."""
        return float(np.sqrt(self.mesh.area)) if self.normalise else 1.0

    @cached_property
    def surface(self) -> TriangleMesh:
        """The mesh in this shape's unit of length: centred, and of unit area if normalised."""
        return self.mesh.scaled(1.0 / self.unit)

    def spectrum(self, k: int | None = None) -> Spectrum:
        """Spectrum of the Laplace-Beltrami operator of `surface`.

        Parameters
        ----------
        k
            Number of eigenpairs, `eigenpairs` by default; at most V are returned.
        """
        return self.unit_spectrum(k).scaled(self.size)

    def unit_spectrum(self, k: int | None = None) -> Spectrum:
        """Spectrum as of :meth:`spectrum`, of the mesh scaled to unit area."""
        k = min(self.eigenpairs if k is None else k, self.n_vertices)
        if self._unit_spectrum is None or self._unit_spectrum.n_eigenpairs < k:
            unit_surface = self.mesh.scaled(1.0 / np.sqrt(self.mesh.area))
            self._unit_spectrum = laplace_beltrami_spectrum(unit_surface, k)
        return self._unit_spectrum.truncated(k)

    @cached_property
    def size(self) -> float:
        """√area in this shape's unit of length: 1 if normalised."""
        return float(np.sqrt(self.mesh.area)) / self.unit

    def metric(self, choice: MetricChoice | str) -> Metric:
        """Metric d_X.

        Parameters
        ----------
        choice
            A metric, or its name. Defaults of parameters with a unit scale with this shape; to
            compare shapes that are not normalised, settle the choice once for all of them.

        Raises
        ------
        OptionError
            The name is unknown.
        MeshError
            The distances cannot be computed on this mesh.
        """
        chosen = metric_choice(choice).settled(self.size)
        if chosen not in self._metrics:
            self._metrics[chosen] = self._new_metric(chosen)
        return self._metrics[chosen]

    def descriptor(
        self, choice: DescriptorChoice | str, vertices: IntArray | None = None
    ) -> FloatArray:
        """Local descriptor f_X.

        Parameters
        ----------
        choice
            A descriptor, or its name; see :meth:`metric`.
        vertices
            (S,) int64 vertices, by default all V.

        Returns
        -------
        (S, m) float64; m is 0 for "none". Eigenfunctions are described by magnitude, which needs
        no other shape (:func:`.eigenfunction_magnitudes`); a match aligns those of its two shapes
        (:func:`.aligned_eigenfunctions`).

        Raises
        ------
        OptionError
            The name is unknown, or the descriptor needs vertex colours and the shape has none.
        """
        chosen = descriptor_choice(choice).settled(self.size)
        if isinstance(chosen, GaussianCurvature | ConformalFactor):
            # Linear systems on the whole surface, solved once for all vertices.
            if chosen not in self._fields:
                self._fields[chosen] = self._new_field(chosen)
            field = self._fields[chosen]
            return field if vertices is None else field[vertices]
        everywhere = np.arange(self.n_vertices) if vertices is None else vertices
        return self._describe(chosen, everywhere)

    def sampling(
        self, choice: MetricChoice | str, count: int, first: tuple[int, ...] = ()
    ) -> FarthestPointSampling:
        """Farthest point sampling in a metric.

        Parameters
        ----------
        choice
            As for :meth:`metric`.
        count
            Number of samples. The longest sampling is kept; shorter ones are its prefixes.
        first
            Vertices that are sampled first, in this order.

        Raises
        ------
        OptionError
            The metric is unknown, or the shape has fewer vertices.
        """
        chosen = metric_choice(choice).settled(self.size)
        known = self._samplings.get((chosen, first))
        if known is None or len(known) < count:
            known = farthest_point_sampling(self.metric(chosen), count, first)
            self._samplings[chosen, first] = known
        return known.first(count)

    def _new_metric(self, chosen: MetricChoice) -> Metric:
        match chosen:
            case Geodesic():
                return GeodesicMetric(geodesics(self.surface, self.geodesic_method))
            case Diffusion(time=float(time)):
                return DiffusionMetric(self.spectrum(), time)
            case CommuteTime():
                return CommuteTimeMetric(self.spectrum())
            case Biharmonic():
                return BiharmonicMetric(self.spectrum())
        raise AssertionError(f"{chosen} cannot be computed")

    def _new_field(self, chosen: GaussianCurvature | ConformalFactor) -> FloatArray:
        match chosen:
            case GaussianCurvature(scale=float(scale)):
                return gaussian_curvature(self.surface, scale)
            case ConformalFactor():
                return conformal_factor(self.surface)
        raise AssertionError(f"{chosen} cannot be computed")

    def _describe(self, chosen: DescriptorChoice, vertices: IntArray) -> FloatArray:
        match chosen:
            case NoDescriptor():
                return np.zeros((len(vertices), 0))
            case Photometric(radius=float(radius)):
                if self.surface.colors is None:
                    raise OptionError("descriptor", WITHOUT_COLORS.format(name="shape"))
                return photometric(self.surface, self.metric("geodesic"), radius, vertices)
            case GeodesicHistogram(radius=float(radius), bins=bins):
                metric = self.metric("geodesic")
                return geodesic_histogram(self.surface, metric, radius, bins, vertices)
            case Eigenfunctions(count=count):
                spectrum = self.spectrum(max(self.eigenpairs, count + 1))
                return eigenfunction_magnitudes(spectrum, count, vertices)
            case HeatKernelSignature(times=tuple(times)):
                return heat_kernel_signature(self.spectrum(), np.array(times), vertices)
            case ScaleInvariantHeatKernelSignature(frequencies=frequencies):
                return scale_invariant_heat_kernel_signature(self.spectrum(), frequencies, vertices)
            case WaveKernelSignature(sigma=sigma):
                return wave_kernel_signature(self.spectrum(), sigma, vertices)
        raise AssertionError(f"{chosen} cannot be computed")
