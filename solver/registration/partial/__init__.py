"""Registration of a whole to a part of it, or of two parts that overlap; the scale is unknown.

:func:`register_part` deforms one onto the other, and finds the vertices that have a partner.
"""

from solver.registration.partial.partiality import OF_OVERLAP, OF_PART
from solver.registration.partial.registration import PartMap, Side, are_cut_across, register_part

__all__ = ["OF_OVERLAP", "OF_PART", "PartMap", "Side", "are_cut_across", "register_part"]
