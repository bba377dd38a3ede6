"""One level of hierarchical matching: two samplings, their structures, and problem (5) on them."""

from dataclasses import dataclass, field, replace

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.errors import OptionError
from solver.labelling import LINF, UNMATCHED, Distortion, LabellingProblem, measure_distortion
from solver.matching.options import MatchOptions
from solver.shape import WITHOUT_COLORS, Shape
from solver.shape.choices import DescriptorChoice, Eigenfunctions, MetricChoice, NoDescriptor
from solver.shape.descriptors import aligned_eigenfunctions

_LEAST, _MOST = 1e-150, 1e150
"""Squares of smaller values vanish, and those of greater ones are infinite."""

NO_LANDMARKS = np.empty((0, 2), dtype=np.int64)
"""No points are known to correspond."""

_COARSE_OVERSAMPLING = 1.5
"""Target samples per source sample at the coarsest level: one in three may be nobody's image."""


@dataclass(frozen=True, eq=False)
class SampledStructure:
    """Sampled points of one shape and its structures there.

    Parameters
    ----------
    vertices
        (n,) vertex indices, farthest first.
    distances
        (n, n) metric d of this level among them.
    descriptors
        (n, m) descriptor f at them; ``None`` when the level has no first-order term.
    """

    vertices: IntArray
    distances: FloatArray
    descriptors: FloatArray | None


@dataclass(frozen=True, eq=False)
class Level:
    """One level of the hierarchy: what is matched, and how it is weighed.

    Parameters
    ----------
    index
        0 for the coarsest.
    metric, descriptor
        The structures.
    source, target
        Sampled structures of X and Y.
    beta, first_order_weight, occlusion_cost
        The options of the match; see ``MatchOptions``.
    landmarks
        How many of the first samples are known to correspond, in their order.
    """

    index: int
    metric: MetricChoice
    descriptor: DescriptorChoice
    source: SampledStructure
    target: SampledStructure
    beta: float
    first_order_weight: float
    occlusion_cost: float
    landmarks: int = field(default=0, kw_only=True)

    def problem(self, candidates: IntArray) -> LabellingProblem:
        """Problem (5) on given candidates.

        Distances are divided by the root mean square of both shapes' distances between source
        samples and between as many target samples, and a pair weighs 2/(N − 1), so that the sum
        over pairs grows like the sum over points. Descriptors are divided by their root mean
        square deviation from their mean. Both shapes share the divisors, so that no difference
        of scale is lost.

        Parameters
        ----------
        candidates
            (V, 2) indices into the two samplings, in lexicographic order.
        """
        unit = self._length_unit()
        n = len(self.source.vertices)
        return LabellingProblem(
            candidates,
            self._unary(candidates),
            self.source.distances / unit,
            self.target.distances / unit,
            self.beta * 2.0 / max(n - 1, 1),
            self.occlusion_cost,
        )

    def allowed(self) -> BoolArray:
        """(N, M) which pairs the landmarks leave: a landmark has its own partner and no other."""
        allowed = np.ones((len(self.source.vertices), len(self.target.vertices)), dtype=np.bool_)
        allowed[: self.landmarks] = allowed[:, : self.landmarks] = False
        np.fill_diagonal(allowed[: self.landmarks, : self.landmarks], True)
        return allowed

    def all_candidates(self) -> IntArray:
        """(V, 2) all pairs, N·M without landmarks: the full graph of the coarsest level."""
        return np.argwhere(self.allowed()).astype(np.int64)

    def distortion(self, partners: IntArray) -> Distortion:
        """Distortion of a correspondence at this level, in the structures' own units.

        Parameters
        ----------
        partners
            (N,) index of each source sample's target sample, `UNMATCHED` for none.
        """
        x = np.flatnonzero(partners != UNMATCHED)
        y = partners[x]
        source, target = self.source.descriptors, self.target.descriptors
        return measure_distortion(
            self.source.distances[np.ix_(x, x)],
            self.target.distances[np.ix_(y, y)],
            None if source is None else source[x],
            None if target is None else target[y],
        )

    def _length_unit(self) -> float:
        n = len(self.source.vertices)
        squares = self.source.distances**2, self.target.distances[:n, :n] ** 2
        mean = sum(float(square.sum()) for square in squares) / max(
            sum(square.shape[0] * (square.shape[0] - 1) for square in squares), 1
        )
        return float(np.sqrt(mean)) or 1.0

    def _unary(self, candidates: IntArray) -> FloatArray:
        source, target = self.source.descriptors, self.target.descriptors
        if source is None or target is None or self.first_order_weight == 0.0:
            return np.zeros(len(candidates))
        both = np.concatenate([source, target])
        unit = float(np.sqrt(((both - both.mean(axis=0)) ** 2).sum(axis=1).mean())) or 1.0
        x, y = candidates.T
        distance: FloatArray = np.linalg.norm(source[x] - target[y], axis=1)
        return self.first_order_weight * distance / unit


def level_sizes(source: Shape, target: Shape, options: MatchOptions) -> list[tuple[int, int]]:
    """Numbers of source and target samples of each level, the coarsest first.

    Parameters
    ----------
    source, target
        The shapes; none can have more samples than vertices.
    options
        Of the match.

    Returns
    -------
    List of (N, M) with N <= M, N growing by at most the level factor up to the points asked for.
    """
    return sizes_between(source.n_vertices, target.n_vertices, options)


def sizes_between(
    most_sources: int, most_targets: int, options: MatchOptions
) -> list[tuple[int, int]]:
    """Numbers of source and target samples of each level, given how many there can be.

    Parameters
    ----------
    most_sources, most_targets
        Bounds on them.
    options
        Of the match.
    """
    most = min(most_sources, most_targets)
    only = options.objective == LINF
    coarse = options.points if only else max(options.coarse_points, len(options.landmarks))
    points = min(coarse, options.points, most)
    wide = int(np.ceil(_COARSE_OVERSAMPLING * points))
    sizes = [(points, min(wide, most_targets))]
    while points < min(options.points, most):
        points = min(points * options.level_factor, options.points, most)
        sizes.append((points, min(points * options.oversampling, most_targets)))
    return sizes


def build_level(
    source: Shape,
    target: Shape,
    index: int,
    size: tuple[int, int],
    options: MatchOptions,
    landmarks: IntArray = NO_LANDMARKS,
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
        Of the match.
    landmarks
        (L, 2) vertices of X and of Y that are known to correspond.

    Raises
    ------
    OptionError
        A shape has too few vertices.
    """
    gamma = np.inf if options.occlusion_cost is None else options.occlusion_cost
    descriptor = options.descriptor_at(index)
    ours, theirs = (
        _sample(source, size[0], index, options, landmarks[:, 0]),
        _sample(target, size[1], index, options, landmarks[:, 1]),
    )
    if not (isinstance(descriptor, NoDescriptor) or options.first_order_weight == 0.0):
        field = f"descriptor.{options.place('descriptor', index)}"
        f, g = described((source, target), descriptor, (ours.vertices, theirs.vertices), field)
        ours, theirs = replace(ours, descriptors=f), replace(theirs, descriptors=g)
    return Level(
        index,
        options.metric_at(index),
        descriptor,
        ours,
        theirs,
        options.beta,
        options.first_order_weight,
        gamma,
        landmarks=len(landmarks),
    )


def _sample(
    shape: Shape, count: int, index: int, options: MatchOptions, landmarks: IntArray
) -> SampledStructure:
    first, metric = options.metric_at(0), options.metric_at(index)
    sampling = shape.sampling(first, count, tuple(landmarks.tolist()))
    vertices = sampling.indices
    same = metric == first
    distances = sampling.distances if same else shape.metric(metric).between(vertices)
    check_distances(metric, distances, f"metric.{options.place('metric', index)}")
    return SampledStructure(vertices, distances, None)


def check_distances(metric: MetricChoice, distances: FloatArray, field: str) -> None:
    """Refuse distances without meaning: a time so long that no heat is left where it was.

    Parameters
    ----------
    metric
        What they are.
    distances
        (M, M) among samples.
    field
        Name of the option that chose the metric.

    Raises
    ------
    OptionError
        They all vanish or exceed all bounds.
    """
    if _LEAST < float(distances.max()) < _MOST:
        return
    names = list(metric.parameters())
    what = "all vanish" if distances.max() <= _LEAST else "exceed all bounds"
    raise OptionError(
        ".".join([field, *names[:1]]),
        f"the {metric.name} distances of a shape {what}; choose another "
        + ("value" if names else "metric, or normalise the shapes"),
    )


def described(
    shapes: tuple[Shape, Shape],
    descriptor: DescriptorChoice,
    vertices: tuple[IntArray, IntArray],
    field: str,
) -> tuple[FloatArray, FloatArray]:
    """Descriptors of two shapes at some vertices of each, comparable with one another."""
    for name, shape in zip(("source", "target"), shapes, strict=True):
        if descriptor.colored and shape.mesh.colors is None:
            raise OptionError(field, WITHOUT_COLORS.replace("shape", name, 1))
    if isinstance(descriptor, Eigenfunctions):
        count = descriptor.count
        spectra = [shape.spectrum(max(shape.eigenpairs, count + 1)) for shape in shapes]
        found = aligned_eigenfunctions(spectra[0], spectra[1], count, *vertices)
    else:
        f, g = (shape.descriptor(descriptor, v) for shape, v in zip(shapes, vertices, strict=True))
        found = f, g
    if not max(np.abs(values).max(initial=0.0) for values in found) < _MOST:
        raise OptionError(field, f"{descriptor.name} exceeds all bounds; normalise the shapes")
    return found
