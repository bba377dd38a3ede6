"""Objectives of a match: the norm of the distortions that is minimised (section 2)."""

from typing import Final

L2: Final = "l2"
"""Sum of squared distortions: the energy (5)."""
LINF: Final = "linf"
"""Greatest distortion of a distance (section 2), minimised by the minimax search."""
