"""Structures (3) of a level: metric and descriptors of both shapes at their samples."""

from dataclasses import replace

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.errors import OptionError
from solver.matching.level import Level, SampledStructure
from solver.matching.options import MatchOptions
from solver.shape import WITHOUT_COLORS, Shape
from solver.shape.choices import DescriptorChoice, Eigenfunctions, MetricChoice, NoDescriptor
from solver.shape.descriptors import aligned_eigenfunctions

_MIN_VALUE, _MAX_VALUE = 1e-150, 1e150
"""Range of values whose squares neither underflow nor overflow in double precision."""

NO_PAIRS: IntArray = np.empty((0, 2), dtype=np.int64)
"""No landmarks, as pairs of vertices."""


def build_level(
    source: Shape,
    target: Shape,
    index: int,
    size: tuple[int, int],
    options: MatchOptions,
    landmarks: IntArray = NO_PAIRS,
) -> Level:
    """Sample both shapes and compute their structures at one level.

    Parameters
    ----------
    source, target
        The shapes X and Y.
    index
        0 for the coarsest level.
    size
        Numbers (N, M) of source and target samples.
    options
        Of the match, settled.
    landmarks
        (L, 2) vertices of X and of Y that are known to correspond.

    Raises
    ------
    OptionError
        A shape has too few vertices, or a structure cannot be computed on it.
    """
    descriptor = options.descriptor_at(index)
    ours = _sample(source, size[0], index, options, landmarks[:, 0])
    theirs = _sample(target, size[1], index, options, landmarks[:, 1])
    if not (isinstance(descriptor, NoDescriptor) or options.first_order_weight == 0.0):
        field = f"descriptor.{options.place('descriptor', index)}"
        vertices = ours.vertices, theirs.vertices
        f, g = descriptors_at((source, target), descriptor, vertices, field)
        ours, theirs = replace(ours, descriptors=f), replace(theirs, descriptors=g)
    return Level(
        index,
        options.metric_at(index),
        descriptor,
        ours,
        theirs,
        options.beta,
        options.first_order_weight,
        np.inf if options.occlusion_cost is None else options.occlusion_cost,
        landmarks=len(landmarks),
    )


def _sample(
    shape: Shape, count: int, index: int, options: MatchOptions, landmarks: IntArray
) -> SampledStructure:
    """Sample a shape farthest first in the coarsest metric, and measure in the level's metric."""
    first, metric = options.metric_at(0), options.metric_at(index)
    sampling = shape.sampling(first, count, tuple(landmarks.tolist()))
    vertices = sampling.indices
    distances = sampling.distances if metric == first else shape.metric(metric).between(vertices)
    check_distances(metric, distances, f"metric.{options.place('metric', index)}")
    return SampledStructure(vertices, distances, None)


def check_distances(metric: MetricChoice, distances: FloatArray, field: str) -> None:
    """Check that squared distances neither underflow, as after a long diffusion, nor overflow.

    Parameters
    ----------
    metric
        Their metric.
    distances
        (M, M) among samples.
    field
        Name of the option that chose the metric.

    Raises
    ------
    OptionError
        All distances vanish, or some overflow.
    """
    if _MIN_VALUE < float(distances.max()) < _MAX_VALUE:
        return
    names = list(metric.parameters())
    fault = "all vanish" if distances.max() <= _MIN_VALUE else "exceed all bounds"
    raise OptionError(
        ".".join([field, *names[:1]]),
        f"the {metric.name} distances of a shape {fault}; choose another "
        + ("value" if names else "metric, or normalise the shapes"),
    )


def check_colors(shape: Shape, name: str, descriptor: DescriptorChoice, field: str) -> None:
    """Check that a shape has the vertex colours that a photometric descriptor needs.

    Parameters
    ----------
    shape
        The shape.
    name
        ``"source"`` or ``"target"``, for the message.
    descriptor
        The descriptor.
    field
        Name of the option that chose it.

    Raises
    ------
    OptionError
        The shape has no colours.
    """
    if descriptor.colored and shape.mesh.colors is None:
        raise OptionError(field, WITHOUT_COLORS.format(name=name))


def descriptors_at(
    shapes: tuple[Shape, Shape],
    descriptor: DescriptorChoice,
    vertices: tuple[IntArray, IntArray],
    field: str,
) -> tuple[FloatArray, FloatArray]:
    """Descriptors (3) of two shapes at some vertices of each, in common coordinates.

    Eigenfunctions are aligned first: their signs and order are arbitrary on each shape.

    Parameters
    ----------
    shapes
        X and Y.
    descriptor
        f.
    vertices
        (N,) vertices of X and (M,) vertices of Y.
    field
        Name of the option that chose the descriptor.

    Returns
    -------
    (N, m) and (M, m) float64.

    Raises
    ------
    OptionError
        A shape has no colours for a photometric descriptor, or values overflow.
    """
    for name, shape in zip(("source", "target"), shapes, strict=True):
        check_colors(shape, name, descriptor, field)
    if isinstance(descriptor, Eigenfunctions):
        count = descriptor.count
        spectra = [shape.spectrum(max(shape.eigenpairs, count + 1)) for shape in shapes]
        found = aligned_eigenfunctions(spectra[0], spectra[1], count, *vertices)
    else:
        f, g = (shape.descriptor(descriptor, v) for shape, v in zip(shapes, vertices, strict=True))
        found = f, g
    if not max(np.abs(values).max(initial=0.0) for values in found) < _MAX_VALUE:
        raise OptionError(field, f"{descriptor.name} exceeds all bounds; normalise the shapes")
    return found
