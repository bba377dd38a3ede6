"""Examples that are left out because their match misfits those of the others."""

import numpy as np

from solver.prototype.learning.matched import _misfitting
from solver.prototype.prototype import MIN_USUAL_ENERGY


def test_examples_of_three_times_the_median_energy_are_left_out() -> None:
    assert _misfitting(np.array([0.0, 1.0, 1.2, 3.2, 0.9, 3.7]), reference=0) == [5]
    assert _misfitting(np.array([1.0, 1.2, 9.0, 0.9, 3.7, 0.8]), reference=2) == [4]


def test_nearly_equal_examples_are_kept() -> None:
    """Their median is a rounding error, and what exceeds it a change of a few points."""
    energies = np.array([0.0, 1e-14, 2e-14, 1e-14, 2.0 * MIN_USUAL_ENERGY])
    assert _misfitting(energies, reference=0) == []
    energies[4] = 4.0 * MIN_USUAL_ENERGY
    assert _misfitting(energies, reference=0) == [4]
