"""Examples of a class put into correspondence by matching (section 5)."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.matching import Correspondence, MatchOptions, match
from solver.prototype.learning.distributions import learn_distributions
from solver.prototype.learning.examples import (
    CorrespondingExamples,
    check_reference,
    check_vertices,
    vertices_of,
)
from solver.prototype.learning.observations import Example, observe
from solver.prototype.learning.propagation import propagate_points
from solver.prototype.matching import match_prototype
from solver.prototype.options import PrototypeOptions
from solver.prototype.prototype import MIN_USUAL_ENERGY, all_pairs
from solver.shape import Shape

# The constants are chosen on generated people and animals.

_PRIOR_SPREAD = 0.1
"""Relative standard deviation of distances over the class, before any example is known."""

_PRIOR_WEIGHT = 2.0
"""Weight of this prior, in examples."""

_MAX_MISFIT = 3.0
"""Ratio to the median misfit beyond which an example is left out."""

_MIN_EXAMPLES = 4
"""Examples below which no preliminary prototype is learned."""

_UNREACHED = (
    "no cycle-consistent registration reaches it, and there are too few examples to check a match"
)
_MISFIT = "its match with the reference misfits those of the others"


def matched_examples(
    shapes: Sequence[Shape],
    options: PrototypeOptions,
    reference: int = 0,
    control: Control | None = None,
) -> CorrespondingExamples:
    """Put shapes of a class into correspondence by matching.

    1. The reference's points are propagated by registrations (:func:`.propagate_points`).
    2. The reference is matched with the shapes not reached; with fewer than four shapes, where no
       other could correct a wrong match, these are left out. A match and its mirror image differ
       little in energy. So the best matches first, of each match's answer and alternatives the one
       is chosen whose distances are most likely given those of the examples before.
    3. A preliminary prototype, with one Gaussian of each distance and descriptor, is matched with
       all shapes, which corrects single points. Shapes that misfit it most are left out.

    Only the shapes reached in step 1 are marked as oriented, and their surfaces kept.

    Parameters
    ----------
    shapes
        M shapes.
    options
        Of the prototype.
    reference
        Place of the reference, the first example.
    control
        Reports progress and cancels.

    Raises
    ------
    Cancelled
        Through `control`.
    OptionError
        An option does not suit the shapes, or one of them has fewer vertices than points.
    """
    control = control or Control()
    check_reference(shapes, reference)
    check_vertices(shapes, options.points)
    first = shapes[reference]
    sampling = options.sampling_metrics[0].settled(first.size)
    own = first.sampling(sampling, options.points).indices
    propagated = propagate_points(shapes, reference, own, control)
    left_out = dict.fromkeys(
        propagated.unreached if len(shapes) < _MIN_EXAMPLES else (), _UNREACHED
    )
    found = {number: [vertices] for number, vertices in propagated.vertices.items()}
    energies = dict.fromkeys(found, 0.0)
    matching = MatchOptions(points=options.points, metric=(sampling, "geodesic"), orientation=False)
    for number, shape in enumerate(shapes):
        control.check()
        if number in found or number in left_out:
            continue
        energies[number], found[number] = _match(first, shape, own, matching, control.quiet())
    order = sorted(found, key=lambda number: (number != reference, energies[number]))
    chosen = _choose_consistent(shapes, found, order, options)
    rematched, misfits = _match_preliminary(shapes, chosen, reference, options, control)
    chosen = {**rematched, **propagated.vertices}
    for number in _misfitting(misfits / options.points, reference):
        left_out[number] = _MISFIT
    kept = [n for n in range(len(shapes)) if n not in left_out]
    kept.sort(key=lambda number: number != reference)
    examples = tuple(Example(shapes[n], chosen[n], n in propagated.vertices) for n in kept)
    return CorrespondingExamples(examples, tuple(kept), misfits, left_out)


def _match(
    first: Shape, other: Shape, own: IntArray, options: MatchOptions, control: Control
) -> tuple[float, list[IntArray]]:
    """Energy of the reference's match with a shape, and the points of all its alternatives."""
    answer = match(first, other, options, control)
    several = [_in_order(first, other, one, own) for one in (answer.best, *answer.alternatives)]
    return answer.best.energy, several


def _in_order(first: Shape, other: Shape, found: Correspondence, own: IntArray) -> IntArray:
    """(N,) partners of the reference's points on the other shape."""
    source = vertices_of(first, found.source, "source")
    target = vertices_of(other, found.target, "target")
    partner = dict(zip(source.tolist(), target.tolist(), strict=True))
    return np.array([partner[vertex] for vertex in own.tolist()], dtype=np.int64)


def _choose_consistent(
    shapes: Sequence[Shape],
    found: Mapping[int, list[IntArray]],
    order: Sequence[int],
    options: PrototypeOptions,
) -> dict[int, IntArray]:
    """Choose one correspondence of each shape, the most likely given those chosen before.

    Distances are assumed to be independent Gaussians with a prior variance.
    """
    metric = options.metrics[0]
    chosen: dict[int, IntArray] = {}
    prior, total, square = 0.0, np.zeros(0), np.zeros(0)
    for taken, number in enumerate(order):
        rows = [
            shapes[number].metric(metric).between(one)[all_pairs(len(one))] for one in found[number]
        ]
        if not taken:
            best = 0
            prior = _PRIOR_WEIGHT * (_PRIOR_SPREAD**2) * float((rows[0] ** 2).mean())
            total, square = np.zeros_like(rows[0]), np.zeros_like(rows[0])
        else:
            mean = total / taken
            scatter = np.maximum(square - taken * mean**2, 0.0)
            variance = (scatter + prior) / (taken + _PRIOR_WEIGHT)
            best = int(np.argmin([((row - mean) ** 2 / variance).sum() for row in rows]))
        chosen[number] = found[number][best]
        total, square = total + rows[best], square + rows[best] ** 2
    return chosen


def _match_preliminary(
    shapes: Sequence[Shape],
    chosen: dict[int, IntArray],
    reference: int,
    options: PrototypeOptions,
    control: Control,
) -> tuple[dict[int, IntArray], FloatArray]:
    """Match a preliminary prototype with all shapes but the reference; return its energies too."""
    misfits = np.zeros(len(shapes))
    if len(shapes) < _MIN_EXAMPLES:
        return chosen, misfits
    order = [reference, *(number for number in chosen if number != reference)]
    examples = [Example(shapes[number], chosen[number]) for number in order]
    single, quiet = replace(options, components=1), control.quiet()
    preliminary = learn_distributions(observe(examples, single, quiet), single, quiet)
    rematched = dict(chosen)
    for number in order[1:]:
        control.check()
        answer = match_prototype(
            preliminary, shapes[number], MatchOptions(points=options.points), quiet
        )
        misfits[number] = answer.best.energy
        target = vertices_of(shapes[number], answer.best.target, "target")
        rematched[number] = target[np.argsort(answer.best.source)]
    return rematched, misfits


def _misfitting(misfits: FloatArray, reference: int) -> list[int]:
    """Places of the shapes whose energy per point exceeds the median of the others by far.

    The median, of all but the reference, counts as :data:`MIN_USUAL_ENERGY` at least: that of
    nearly equal shapes is a rounding error.
    """
    if len(misfits) <= 2:
        return []
    usual = float(np.median(np.delete(misfits, reference)))
    limit = _MAX_MISFIT * max(usual, MIN_USUAL_ENERGY)
    return [n for n, misfit in enumerate(misfits) if n != reference and misfit > limit]
