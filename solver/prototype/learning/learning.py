"""Prototypes learned from examples in correspondence: section 5."""

from collections.abc import Sequence
from dataclasses import replace

from solver.control import Control
from solver.prototype.learning.cross_validation import left_out_energies
from solver.prototype.learning.distributions import learn_distributions
from solver.prototype.learning.observations import Example, observe
from solver.prototype.options import PrototypeOptions
from solver.prototype.prototype import Prototype
from solver.prototype.surfaces import example_surfaces


def learn_prototype(
    examples: Sequence[Example], options: PrototypeOptions, control: Control | None = None
) -> Prototype:
    """Learn the distributions of distances and descriptors, and keep surfaces of the examples.

    Parameters
    ----------
    examples
        M >= 1 shapes in correspondence, the reference first, their points farthest first. All of
        them are normalised or none, and their structures are computed with the same settings.
    options
        Of the prototype. If the examples have more points, the first ones are used; if they have
        fewer, the prototype has as many as they.
    control
        Reports progress and cancels.

    Returns
    -------
    Prototype
        The same for any order of the examples after the first, up to rounding and to the choice of
        those that are left out for cross-validation.

    Raises
    ------
    Cancelled
        Through `control`.
    OptionError
        A structure cannot be computed on these shapes.
    PrototypeError
        There are no examples, or they do not correspond.

    Examples
    --------
    >>> options = PrototypeOptions(points=32, components=5)
    >>> examples = matched_examples(shapes, options).examples
    >>> prototype = learn_prototype(examples, options)
    >>> found = match_prototype(prototype, target)
    """
    control = control or Control()
    seen = observe(examples, options, control)
    learned = learn_distributions(seen, options, control)
    control.report("examples left out by turns", 0.95)
    energies = left_out_energies(seen, options, control)
    control.report("surfaces of the examples", 0.98)
    oriented = [one for one in seen.examples if one.oriented]
    shapes, points = [one.shape for one in oriented], [one.vertices for one in oriented]
    surfaces = example_surfaces(shapes, points, control)
    return replace(learned, left_out_energies=energies, surfaces=surfaces)
