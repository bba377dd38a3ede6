"""Ways in which a mesh file can be damaged, each with what should become of it.

A damage takes a closed surface without symmetry and returns what a careless program would have
written, and where the vertices of the surface are in that. Those of `HARMLESS` leave the surface
as it is, and must not be noticed in any answer; those of `DISTORTING` change it, and must be told
of; `REFUSED` are to be refused, with a reason.
"""

from collections.abc import Mapping

from tests.solver.mesh.repair.damage import (
    coordinates,
    degenerate,
    numbering,
    orientation,
    repetition,
    seams,
)
from tests.solver.mesh.repair.damage.damaged import Damage, Damaged, name_of, read
from tests.solver.mesh.repair.damage.distorting import DISTORTING
from tests.solver.mesh.repair.damage.refused import REFUSED

__all__ = ["DISTORTING", "HARMLESS", "REFUSED", "Damage", "Damaged", "name_of", "read"]

HARMLESS: Mapping[Damage, str] = {
    **numbering.TOLD,
    **repetition.TOLD,
    **seams.TOLD,
    **degenerate.TOLD,
    **orientation.TOLD,
    **coordinates.TOLD,
}
"""The surface is the same, and all distances on it; with what the user is told."""
