"""Distributions of structures, learned from examples in correspondence: section 5."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import eigh

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.errors import OptionError, PrototypeError
from solver.prototype.mixtures import fit_mixtures
from solver.prototype.options import PrototypeOptions
from solver.prototype.prototype import LearnedDescriptors, LearnedDistances, Prototype, all_pairs
from solver.shape import WITHOUT_COLORS, Shape
from solver.shape.choices import (
    DescriptorChoice,
    Eigenfunctions,
    MetricChoice,
    NoDescriptor,
    Structure,
)

_DISTANCE_FLOOR = 0.1
"""Least standard deviation of a distance, relative to the root mean square of all distances. A
target's samples are not the images of the prototype's points, and a target may lie outside of what
the examples show: narrower components would claim to know better."""

_DESCRIPTOR_FLOOR = 0.7
"""Least variance of a component, relative to that about the points' means over the class."""

_AXES = 4
"""Axes of a descriptor that are modelled."""

_RIDGE = 0.02
"""Of the variance about the points' means, which is added along every axis."""

_TOTAL = 0.01
"""Of the variance over all points and examples, which is added, for the sake of few examples."""

_BACKGROUND = 1e-6
"""Share of distances and descriptors that are taken to be nobody's."""


@dataclass(frozen=True, eq=False)
class Example:
    """A shape of the class, and where the prototype's points are on it.

    Parameters
    ----------
    shape
        The shape.
    vertices
        (N,) vertices of its mesh that correspond to the prototype's points, in their order.
    oriented
        Whether left is known to be left on it: distances do not say, and its surface would.
    """

    shape: Shape
    vertices: IntArray
    oriented: bool = True


@dataclass(frozen=True, eq=False)
class Observed:
    """The structures of examples at the prototype's points.

    Parameters
    ----------
    examples
        M examples of N points.
    metrics, descriptors
        Of each level, settled.
    samples
        (P, M, 1) distances or (N, M, m) descriptors of all examples, by structure.
    """

    examples: tuple[Example, ...]
    metrics: tuple[MetricChoice, ...]
    descriptors: tuple[DescriptorChoice, ...]
    samples: Mapping[Structure, FloatArray]

    def chosen(self, places: Sequence[int], points: int) -> "Observed":
        """The first points of some of the examples."""
        kept = [self.examples[place] for place in places]
        examples = tuple(replace(one, vertices=one.vertices[:points]) for one in kept)
        rows: dict[Structure, int] = dict.fromkeys(self.descriptors, points)
        rows |= dict.fromkeys(self.metrics, points * (points - 1) // 2)
        samples = {one: self.samples[one][: rows[one]][:, list(places)] for one in rows}
        return replace(self, examples=examples, samples=samples)


def observed(examples: Sequence[Example], options: PrototypeOptions, control: Control) -> Observed:
    """Compute the structures of examples.

    Parameters
    ----------
    examples
        M >= 1 shapes in correspondence, the reference first.
    options
        Of the prototype.
    control
        Reports progress and cancels.

    Raises
    ------
    Cancelled
        Through `control`.
    OptionError
        A structure cannot be computed on these shapes.
    PrototypeError
        There are no examples, or they do not correspond.
    """
    examples = _consistent(examples, options.points)
    length = _mean_size(examples)
    metrics = tuple(one.settled(length) for one in options.metrics)
    descriptors = tuple(one.settled(length) for one in options.descriptors)
    samples = _samples(examples, (*metrics, *descriptors), control)
    return Observed(tuple(examples), metrics, descriptors, samples)


def learn_distributions(
    seen: Observed, options: PrototypeOptions, control: Control | None = None
) -> Prototype:
    """Learn a prototype of distributions alone, for matches that are not to tell left from right.

    Parameters
    ----------
    seen
        The examples.
    options
        Of the prototype.
    control
        Reports progress and cancels.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    control = control or Control()
    samples = seen.samples
    control.report("mixtures of distances", 0.8)
    distances = {
        one: _learn_distances(one, samples[one], options) for one in dict.fromkeys(seen.metrics)
    }
    control.report("mixtures of descriptors", 0.93)
    fields = {
        one: _learn_descriptors(one, samples[one], options)
        for one in dict.fromkeys(seen.descriptors)
    }
    first, length = seen.examples[0], _mean_size(seen.examples)
    return Prototype(
        distances=tuple(distances[one] for one in seen.metrics),
        descriptors=tuple(fields[one] for one in seen.descriptors),
        sampling=tuple(one.settled(length) for one in options.sampling_metrics),
        positions=first.shape.mesh.vertices[first.vertices],
        vertices=first.shape.mesh.vertex_ids[first.vertices],
        components=options.components,
        examples=len(seen.examples),
        normalise=first.shape.normalise,
        eigenpairs=first.shape.eigenpairs,
        geodesic_method=first.shape.geodesic_method,
    )


def _mean_size(examples: Sequence[Example]) -> float:
    """Geometric mean of √area, in which parameters that are lengths are settled."""
    return float(np.exp(np.mean([np.log(one.shape.size) for one in examples])))


def _consistent(examples: Sequence[Example], points: int) -> list[Example]:
    if not examples:
        raise PrototypeError("a prototype needs at least one example")
    first = examples[0]
    count = len(first.vertices)
    for number, example in enumerate(examples):
        if len(example.vertices) != count:
            raise PrototypeError(
                f"example {number} has {len(example.vertices)} points and the first {count}"
            )
        if not (example.vertices.min() >= 0 and example.vertices.max() < example.shape.n_vertices):
            raise PrototypeError(f"example {number} has points that are no vertices of its shape")
        ways = [
            (one.shape.normalise, one.shape.eigenpairs, one.shape.geodesic_method)
            for one in (first, example)
        ]
        if ways[0] != ways[1]:
            raise PrototypeError(f"the structures of example {number} are computed in another way")
    if count < 2:
        raise PrototypeError("a prototype needs at least two points")
    return [replace(one, vertices=one.vertices[:points]) for one in examples]


def _samples(
    examples: list[Example], choices: Sequence[Structure], control: Control
) -> dict[Structure, FloatArray]:
    """(P, M, 1) distances or (N, M, m) descriptors of all examples, by structure."""
    distinct = list(dict.fromkeys(choices))
    samples = {}
    for place, choice in enumerate(distinct):
        collected = []
        for number, example in enumerate(examples):
            done = (place + number / len(examples)) / len(distinct)
            control.report("structures of the examples", 0.8 * done)
            collected.append(_structure(example, choice))
        samples[choice] = np.stack(collected, axis=1)
    return samples


def _structure(example: Example, choice: Structure) -> FloatArray:
    """(P, 1) distances among an example's points, or (N, m) descriptors at them."""
    if isinstance(choice, MetricChoice):
        distances = example.shape.metric(choice).between(example.vertices)
        return distances[all_pairs(len(example.vertices))][:, None]
    if isinstance(choice, Eigenfunctions):
        raise OptionError("descriptor", "eigenfunctions of two shapes have no common signs")
    if choice.colored and example.shape.mesh.colors is None:
        raise OptionError("descriptor", WITHOUT_COLORS)
    assert isinstance(choice, DescriptorChoice)
    return example.shape.descriptor(choice, example.vertices)


def _learn_distances(
    metric: MetricChoice, samples: FloatArray, options: PrototypeOptions
) -> LearnedDistances:
    size = float(np.sqrt((samples**2).mean())) or 1.0
    floor = np.array([(_DISTANCE_FLOOR * size) ** 2])
    fit = fit_mixtures(
        samples,
        options.components,
        floor,
        select=options.select_components,
        seed=options.seed,
    )
    widest = float(samples.max()) or 1.0
    return LearnedDistances(metric, fit.mixtures, float(np.log(_BACKGROUND / (2.0 * widest))))


def _learn_descriptors(
    descriptor: DescriptorChoice, samples: FloatArray, options: PrototypeOptions
) -> LearnedDescriptors | None:
    if isinstance(descriptor, NoDescriptor) or samples.shape[2] == 0:
        return None
    centre = samples.mean(axis=(0, 1))
    axes = discriminant_axes(samples, _AXES)
    if not axes.shape[1]:
        return None
    coordinates = (samples - centre) @ axes
    fit = fit_mixtures(
        coordinates,
        options.components,
        np.full(axes.shape[1], _DESCRIPTOR_FLOOR),
        diagonal=True,
        select=options.select_components,
        seed=options.seed,
    )
    spread = coordinates.reshape(-1, axes.shape[1]).std(axis=0)
    # As high as the peak of a Gaussian twice as wide as everything that was seen.
    peak = -float(np.log(2.0 * np.sqrt(2.0 * np.pi) * np.maximum(spread, 1.0)).sum())
    background = float(np.log(_BACKGROUND)) + peak
    return LearnedDescriptors(descriptor, centre, axes, fit.mixtures, background)


def discriminant_axes(samples: FloatArray, most: int) -> FloatArray:
    """Axes along which points differ most, relative to how much each varies over the examples.

    A descriptor of many dimensions says the same thing several times, and most of its variance is
    of no use: it is that of the class. Fisher's discriminant (1936) leaves the part that tells
    points apart; what it leaves out is taken to be distributed alike at all points, so that it
    cancels.

    Parameters
    ----------
    samples
        (N, M, m) descriptors of N points on M examples.
    most
        How many axes at most.

    Returns
    -------
    (m, r) float64; along each axis the mean variance of a point is 1, or less where there are few
    examples. r is 0 if all descriptors are equal.
    """
    means = samples.mean(axis=1)
    about = samples - means[:, None, :]
    size = samples.shape[0] * samples.shape[1]
    within = np.einsum("nsi,nsj->ij", about, about) / size
    between = np.cov(means.T, bias=True).reshape(within.shape)
    if not np.trace(within + between) > 0.0:
        return np.zeros((samples.shape[2], 0))
    m = len(within)
    ridge = _RIDGE * np.trace(within) / m + 1e-9 * np.trace(within + between) / m
    noise = within + _TOTAL * (within + between) + ridge * np.eye(m)
    _, vectors = eigh(between, noise)
    axes: FloatArray = vectors[:, ::-1][:, : min(most, m)]
    signs = np.sign(axes[np.abs(axes).argmax(axis=0), np.arange(axes.shape[1])])
    turned: FloatArray = axes * signs
    return turned
