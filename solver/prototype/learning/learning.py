"""Prototypes learned from examples in correspondence: section 5."""

from collections.abc import Sequence
from dataclasses import replace

from solver.control import Control
from solver.prototype.learning.distributions import Example, learn_distributions, observed
from solver.prototype.learning.misfit import left_out_energies
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
        M >= 1 shapes in correspondence, their points farthest first. The first one is the
        reference that pictures show. All of them normalised, or none, and with structures computed
        in the same way.
    options
        Of the prototype. More than N points cannot be learned from examples with N points; of more,
        the first ones are taken.
    control
        Reports progress and cancels.

    Returns
    -------
    Prototype
        The same for any order of the examples but the first, up to rounding, save which of them
        say what is usual.

    Raises
    ------
    Cancelled
        Through `control`.
    OptionError
        A structure cannot be computed on these shapes.
    PrototypeError
        There are no examples, or they do not correspond.
    """
    control = control or Control()
    seen = observed(examples, options, control)
    learned = learn_distributions(seen, options, control)
    control.report("examples left out by turns", 0.95)
    energies = left_out_energies(seen, options, control)
    control.report("surfaces of the examples", 0.98)
    oriented = [one for one in seen.examples if one.oriented]
    shapes, points = [one.shape for one in oriented], [one.vertices for one in oriented]
    surfaces = example_surfaces(shapes, points, control)
    return replace(learned, left_out_energies=energies, surfaces=surfaces)
