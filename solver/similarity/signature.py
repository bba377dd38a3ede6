"""Signature of a shape for comparisons: a few samples, and metric and descriptor at them.

Farthest point sampling is the unstable part of a comparison: a change of pose may change the order
of two extremities, so that the sixth point is on another limb. No metric samples all shapes stably,
but in one or another of several metrics the samples of two similar shapes nearly always correspond.
A signature therefore has several samplings, and a comparison uses the best of them.
"""

import io
from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.errors import OptionError
from solver.labelling import L2, LINF
from solver.matching import MIN_POINTS
from solver.parameters import ParameterSet, parameter
from solver.shape import Shape
from solver.shape.choices import (
    DescriptorChoice,
    MetricChoice,
    NoDescriptor,
    descriptor_choice,
    metric_choice,
)
from solver.similarity.qap import MAX_POINTS

SAMPLINGS = ("geodesic", "commute_time", "biharmonic")
"""Metrics of farthest point sampling."""

_LEAST_DIAMETER = 1e-150
"""Diameter below which squared distances underflow, in the metric's unit."""


@dataclass(frozen=True)
class SimilarityOptions(ParameterSet):
    """Options of a comparison; the name of a structure stands for default parameters.

    Raises
    ------
    OptionError
        A value is out of range.
    """

    points: int = parameter(
        6,
        "Points of each shape. All of them are matched, to proven optimality.",
        least=MIN_POINTS,
        most=MAX_POINTS,
    )
    metric: MetricChoice | str = parameter(
        "commute_time", "Distance whose distortion is measured.", topic="Structures"
    )
    descriptor: DescriptorChoice | str = parameter(
        "si_hks",
        "Local descriptor of the first-order term. Not used without a `first_order_weight`. Of"
        " eigenfunctions only magnitudes are compared.",
        topic="Structures",
    )
    first_order_weight: float = parameter(
        0.0,
        "Weight of the first-order (descriptor) term.",
        least=0.0,
        most=1e6,
        topic="Solver",
    )
    objective: str = parameter(
        L2,
        'Dissimilarity of two shapes. "l2" is the least energy (5) per matched point. "linf" is'
        " the least maximal distortion of a distance, half of which bounds the Gromov-Hausdorff"
        " distance of the samples from above; it has no first-order term.",
        one_of=(L2, LINF),
        topic="Solver",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "metric", metric_choice(self.metric))
        object.__setattr__(self, "descriptor", descriptor_choice(self.descriptor))

    @property
    def described(self) -> bool:
        """Whether descriptors are compared."""
        weighed = self.first_order_weight > 0.0 and self.objective == L2
        return weighed and not isinstance(self.descriptor, NoDescriptor)


@dataclass(frozen=True, eq=False)
class Signature:
    """Samples of a shape and its structures there, a few kilobytes.

    Parameters
    ----------
    vertices
        (S, n) vertex indices, of each sampling farthest first. There are as many as can be
        compared, or as the shape has vertices; the first N of them are a sampling themselves.
    distances
        (S, n, n) metric d among the points of each sampling, exactly symmetric.
    descriptors
        (S, n, m) descriptor f at them; m = 0 when none is compared.
    """

    vertices: IntArray
    distances: FloatArray
    descriptors: FloatArray

    @property
    def points(self) -> int:
        """Number n of points of each sampling."""
        return int(self.vertices.shape[1])

    def first(self, points: int) -> "Signature":
        """Return the signature of the first points of each sampling.

        Raises
        ------
        OptionError
            There are fewer.
        """
        _check(points, self.points)
        return Signature(
            self.vertices[:, :points],
            self.distances[:, :points, :points],
            self.descriptors[:, :points],
        )

    def to_bytes(self) -> bytes:
        """Return the signature as the bytes of three ``.npy`` files, exact to the last bit."""
        stream = io.BytesIO()
        for array in (self.vertices, self.distances, self.descriptors):
            np.save(stream, array, allow_pickle=False)
        return stream.getvalue()

    @classmethod
    def from_bytes(cls, data: bytes) -> "Signature":
        """Read what :meth:`to_bytes` wrote.

        Raises
        ------
        ValueError
            The bytes are something else. Nothing in them is ever executed.
        """
        try:
            stream = io.BytesIO(data)
            found = cls(*(np.load(stream, allow_pickle=False) for _ in range(3)))
            kinds, points = found.vertices.shape
            shapes = found.distances.shape, found.descriptors.shape[:2]
        except MemoryError:
            raise
        except Exception as error:
            raise ValueError(f"not a stored signature: {error}") from error
        if shapes != ((kinds, points, points), (kinds, points)):
            raise ValueError("not a stored signature: arrays of wrong shape")
        return found


def signature(shape: Shape, options: SimilarityOptions) -> Signature:
    """Sample a shape and compute its structures at the samples.

    Parameters
    ----------
    shape
        A shape X.
    options
        Of the comparison.

    Returns
    -------
    Signature
        Of the samplings in `SAMPLINGS`; the same for any number of points.

    Raises
    ------
    OptionError
        The shape has fewer vertices than points are asked for, or its distances vanish.
    MeshError
        Its structures cannot be computed.
    """
    _check(options.points, shape.n_vertices)
    points = min(MAX_POINTS, shape.n_vertices)
    vertices = np.stack([shape.sampling(name, points).indices for name in SAMPLINGS])
    chosen = metric_choice(options.metric)
    metric = shape.metric(chosen)
    distances = np.stack([metric.between(sampled) for sampled in vertices])
    if distances.max(axis=(1, 2)).min() < _LEAST_DIAMETER:
        field = ".".join(["metric", *chosen.parameters()])
        raise OptionError(
            field, f"the {chosen.name} distances of a shape all vanish; choose another value"
        )
    descriptors = np.zeros((*vertices.shape, 0))
    if options.described:
        found = [shape.descriptor(options.descriptor, sampled) for sampled in vertices]
        descriptors = np.stack(found)
    return Signature(vertices, distances, descriptors)


def _check(points: int, most: int) -> None:
    if points > most:
        raise OptionError("points", f"the shape has only {most} vertices; {points} were asked for")
