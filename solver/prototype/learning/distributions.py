"""Distributions of distances and descriptors, learned from corresponding examples (section 5)."""

import numpy as np

from solver.arrays import FloatArray
from solver.control import Control
from solver.prototype.learning.discriminant import discriminant_axes
from solver.prototype.learning.observations import Observations, mean_size
from solver.prototype.mixtures import fit_mixtures
from solver.prototype.options import PrototypeOptions
from solver.prototype.prototype import LearnedDescriptors, LearnedDistances, Prototype
from solver.shape.choices import DescriptorChoice, MetricChoice, NoDescriptor

# The constants are chosen on generated people and animals.

_DISTANCE_FLOOR = 0.1
"""Least standard deviation of a distance, relative to the root mean square of all distances.
Samples of a target are not the images of the prototype's points, and a target may differ from all
examples: narrower components would claim too much certainty."""

_DESCRIPTOR_FLOOR = 0.7
"""Least variance of a component, relative to the mean variance within points over the examples."""

_DESCRIPTOR_AXES = 4
"""Greatest number of discriminant axes of a descriptor that are modelled."""

_BACKGROUND_SHARE = 1e-6
"""Weight of the uniform background, of outliers, in every mixture: it bounds the cost of a pair."""


def learn_distributions(
    seen: Observations, options: PrototypeOptions, control: Control
) -> Prototype:
    """Learn the distributions of a prototype, without surfaces for orientation (section 5).

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
    samples = seen.samples
    control.report("mixtures of distances", 0.8)
    distances = {
        one: _learn_distances(one, samples[one], options, control)
        for one in dict.fromkeys(seen.metrics)
    }
    control.report("mixtures of descriptors", 0.93)
    fields = {
        one: _learn_descriptors(one, samples[one], options, control)
        for one in dict.fromkeys(seen.descriptors)
    }
    first, length = seen.examples[0], mean_size(seen.examples)
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


def _learn_distances(
    metric: MetricChoice, samples: FloatArray, options: PrototypeOptions, control: Control
) -> LearnedDistances:
    """Fit a mixture to the distances of every pair of points."""
    size = float(np.sqrt((samples**2).mean())) or 1.0
    floor = np.array([(_DISTANCE_FLOOR * size) ** 2])
    fit = fit_mixtures(
        samples,
        options.components,
        floor,
        control,
        select=options.select_components,
        seed=options.seed,
    )
    widest = float(samples.max()) or 1.0  # the background is uniform up to twice this distance
    background = float(np.log(_BACKGROUND_SHARE / (2.0 * widest)))
    return LearnedDistances(metric, fit.mixtures, background)


def _learn_descriptors(
    descriptor: DescriptorChoice, samples: FloatArray, options: PrototypeOptions, control: Control
) -> LearnedDescriptors | None:
    """Fit a mixture to the descriptor of every point, along its discriminant axes."""
    if isinstance(descriptor, NoDescriptor) or samples.shape[2] == 0:
        return None
    centre = samples.mean(axis=(0, 1))
    axes = discriminant_axes(samples, _DESCRIPTOR_AXES)
    if not axes.shape[1]:
        return None
    coordinates = (samples - centre) @ axes
    fit = fit_mixtures(
        coordinates,
        options.components,
        np.full(axes.shape[1], _DESCRIPTOR_FLOOR),
        control,
        diagonal=True,
        select=options.select_components,
        seed=options.seed,
    )
    spread = coordinates.reshape(-1, axes.shape[1]).std(axis=0)
    # The peak of a Gaussian twice as wide as the distribution of all points and examples.
    peak = -float(np.log(2.0 * np.sqrt(2.0 * np.pi) * np.maximum(spread, 1.0)).sum())
    background = float(np.log(_BACKGROUND_SHARE)) + peak
    return LearnedDescriptors(descriptor, centre, axes, fit.mixtures, background)
