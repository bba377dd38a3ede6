"""Minimisation of the energy (5), section 4: dual decomposition, exact search, local search."""

from solver.optimisation.minimise import minimise
from solver.optimisation.reparametrisation import ReparametrisedCosts

__all__ = ["ReparametrisedCosts", "minimise"]
