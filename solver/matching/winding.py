"""Winding of open surfaces, which in a file may be opposite to that of the other shape.

Repair winds surfaces outwards that are closed or nearly so. Of others, such as half a body or a
sheet, it cannot tell the outside. Their sides are told by the other shape: with its outside in, a
surface fits worse.
"""

from dataclasses import replace

import numpy as np

from solver.control import Control
from solver.registration import STAGE, first_score
from solver.registration.reduction import FEW_VERTICES, Reduction
from solver.shape import Shape

_OPEN = 1.9
"""Least length of a cut over √area of a surface that repair may not have wound outwards: a shorter
loop is spanned by less than 0.3 of the area, by the isoperimetric inequality."""

_MARGIN = 0.5
"""How much less the score has to be with the winding reversed. Of 12 halves of bodies and 20 views
of one side the score is 0.65 to 3.2 greater with the wrong winding; of two flat discs, 0.2."""


def wound_alike(source: Shape, target: Shape, control: Control) -> tuple[Shape, Shape]:
    """Reverse the winding of the more open of two shapes, if it fits the other far better then.

    Parameters
    ----------
    source, target
        The shapes X and Y.
    control
        Cancels.

    Returns
    -------
    The same shapes, or one of them with its winding reversed, and with a warning.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    ours, theirs = (one.mesh.longest_cut for one in (source, target))
    if max(ours, theirs) < _OPEN:
        return source, target
    with control.stage(STAGE):
        here, there = (Reduction.of(one, FEW_VERTICES).shape for one in (source, target))
        given, _ = first_score(here, there, control)
        other, _ = first_score(_reversed(here), there, control)
    if other < given - _MARGIN:
        return (_reversed(source), target) if ours > theirs else (source, _reversed(target))
    return source, target


def _reversed(shape: Shape) -> Shape:
    """Return a shape with its winding reversed, which has the same spectrum."""
    mesh = shape.mesh
    note = "flipped all faces of the surface: it fits the other far better with this outside"
    faces = np.ascontiguousarray(mesh.faces[:, ::-1])
    return shape.with_mesh(
        replace(mesh, faces=faces, warnings=(*mesh.warnings, note)), shape.unit_spectrum()
    )
