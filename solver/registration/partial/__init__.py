"""Registration of a whole to a part of it, whose scale is unknown.

:func:`register_part` bends the whole onto the part, and says what of it the part covers.
"""

from solver.registration.partial.registration import PartMap, register_part

__all__ = ["PartMap", "register_part"]
