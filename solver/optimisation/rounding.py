"""Allowance for rounding errors where energies and bounds are compared."""

from typing import Final

from solver.kernel import inlined

ROUNDING: Final = 1e-12
"""Allowance for rounding errors of bounds and of costs that were moved, relative to them."""


@inlined
def allowance(energy: float, scale: float) -> float:
    """Difference of energies up to which they count as equal.

    It is relative to the costs as well as to their sum, which may be small by cancellation, or
    because distances agree. An absolute one would hide all differences of problems of small costs.

    Parameters
    ----------
    energy
        An energy or a bound, finite.
    scale
        Of the costs that add up to it: :attr:`.LabellingProblem.scale`.
    """
    return ROUNDING * (scale + abs(energy))
