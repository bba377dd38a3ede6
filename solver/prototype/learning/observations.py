"""Structures of examples in correspondence, from which a prototype is learned (section 5)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.errors import OptionError, PrototypeError
from solver.prototype.options import PrototypeOptions
from solver.prototype.prototype import all_pairs
from solver.shape import WITHOUT_COLORS, Shape
from solver.shape.choices import DescriptorChoice, Eigenfunctions, MetricChoice, Structure


@dataclass(frozen=True, eq=False)
class Example:
    """A shape of the class with the prototype's points on it.

    Parameters
    ----------
    shape
        The shape.
    vertices
        (N,) vertices of its mesh that correspond to the prototype's points, in their order.
    oriented
        Whether the points are known to preserve orientation; distances do not show it, but its
        surface is kept for that.
    """

    shape: Shape
    vertices: IntArray
    oriented: bool = True


@dataclass(frozen=True, eq=False)
class Observations:
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

    def chosen(self, places: Sequence[int], points: int) -> "Observations":
        """Return the first points of some of the examples.

        Parameters
        ----------
        places
            Of the examples.
        points
            Number of points.
        """
        kept = [self.examples[place] for place in places]
        examples = tuple(replace(one, vertices=one.vertices[:points]) for one in kept)
        rows: dict[Structure, int] = dict.fromkeys(self.descriptors, points)
        rows |= dict.fromkeys(self.metrics, points * (points - 1) // 2)
        samples = {one: self.samples[one][: rows[one]][:, list(places)] for one in rows}
        return replace(self, examples=examples, samples=samples)


def observe(
    examples: Sequence[Example], options: PrototypeOptions, control: Control
) -> Observations:
    """Compute the structures (3) of examples at the prototype's points.

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
    length = mean_size(examples)
    metrics = tuple(one.settled(length) for one in options.metrics)
    descriptors = tuple(one.settled(length) for one in options.descriptors)
    samples = _samples(examples, (*metrics, *descriptors), control)
    return Observations(tuple(examples), metrics, descriptors, samples)


def mean_size(examples: Sequence[Example]) -> float:
    """Geometric mean of √area, the unit of the parameters that are lengths."""
    return float(np.exp(np.mean([np.log(one.shape.size) for one in examples])))


def _consistent(examples: Sequence[Example], points: int) -> list[Example]:
    """Check that examples correspond, and return them with the first points only."""
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
            raise PrototypeError(f"example {number} has points that are not vertices of its shape")
        ways = [
            (one.shape.normalise, one.shape.eigenpairs, one.shape.geodesic_method)
            for one in (first, example)
        ]
        if ways[0] != ways[1]:
            raise PrototypeError(
                f"the structures of example {number} are computed with other settings"
            )
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
        raise OptionError("descriptor", WITHOUT_COLORS.format(name="shape"))
    assert isinstance(choice, DescriptorChoice)
    return example.shape.descriptor(choice, example.vertices)
