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
class SimilarityOptions:
    """Choices of a comparison; the paper's symbols in parentheses.

    Parameters
    ----------
    points
        Points N of each shape that are matched, all with all.
    metric
        Metric d whose distortion is measured: a choice, or a name for the one with default
        parameters.
    descriptor
        Descriptor f of the first-order term, likewise; ``"none"``, or a weight of 0, leaves it
        out.
    first_order_weight
        Weight of the first-order term, as for a match.
    objective
        ``"l2"``, the energy (5), or ``"linf"``, the greatest distortion of a distance, which knows
        no first-order term.

    Raises
    ------
    OptionError
        A value is out of range.
    """

    points: int = 6
    metric: MetricChoice | str = "commute_time"
    descriptor: DescriptorChoice | str = "si_hks"
    first_order_weight: float = 0.0
    objective: str = L2

    def __post_init__(self) -> None:
        if not MIN_POINTS <= self.points <= MAX_POINTS:
            raise OptionError("points", f"it must be from {MIN_POINTS} to {MAX_POINTS}")
        object.__setattr__(self, "metric", metric_choice(self.metric))
        object.__setattr__(self, "descriptor", descriptor_choice(self.descriptor))
        if not 0.0 <= self.first_order_weight <= 1e6:
            raise OptionError("first_order_weight", "it must be from 0 to 1e+06")
        if self.objective not in (L2, LINF):
            raise OptionError("objective", f"{self.objective!r} is none of {L2}, {LINF}")

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
