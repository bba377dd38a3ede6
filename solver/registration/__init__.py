"""Registration: bending one surface onto the other, which tells how well a correspondence fits."""

from solver.registration.confidence import Confidence

__all__ = ["Confidence"]
