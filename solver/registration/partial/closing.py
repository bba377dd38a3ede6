"""Candidates of a part whose holes are closed: it is registered as if nothing were missing.

Holes change shortest paths, and eigenfunctions more; of some parts, no labelling leads to a right
candidate. With its holes closed by flat fans, both are nearly those of the whole where little is
missing, and candidates are found as for two whole shapes. The displacement of the whole, and all
that is measured, is that of the part as it is.
"""

from collections.abc import Iterator

import numpy as np

from solver.arrays import IntArray
from solver.control import Control
from solver.functional_maps import mutual_nearest_points
from solver.mesh.holes import with_holes_closed
from solver.registration.candidates import first_pairs
from solver.registration.choice import COARSE, Task, choose
from solver.registration.crossing import cross
from solver.registration.partial.candidates import first_alignment
from solver.registration.partial.choice import PartTask, Start
from solver.registration.surface import smooth_surface
from solver.shape import Shape

_POINTS = 200
"""Points of the part whose partners say where a candidate begins."""

_WHOLE_SAMPLES = 500
"""Samples of the whole that these are chosen from."""


def starts_with_holes_closed(
    task: PartTask, part: Shape, scale: float | None, control: Control
) -> Iterator[Start]:
    """Yield where candidates begin that were registered to the part with its holes closed.

    Parameters
    ----------
    task
        The surfaces.
    part
        The part; nothing is yielded if it has no holes.
    scale
        √area of the whole over √area of the part, if it is known. Else the area of what closes the
        holes is taken to be that of what is missing.
    control
        May cancel; past its deadline, fewer candidates are tried.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    mesh = with_holes_closed(part.surface)
    if mesh is None or control.expired:
        return
    here, theirs = task.part.samples.vertices[:_POINTS], task.landmarks[1]
    places, landmarks = mesh.vertices_of(here), mesh.vertices_of(theirs)
    if (places < 0).any() or (landmarks < 0).any():
        return  # what was closed needed repairs
    whole, closed = task.whole, smooth_surface(Shape(mesh))
    one = float(np.sqrt(mesh.area / part.surface.area)) if scale is None else scale
    surfaces = Task(whole, closed, (whole.samples, closed.samples), (task.landmarks[0], landmarks))
    for there in _partners(surfaces, places, control):
        yield first_alignment(task.whole, task.part, (there, here), one), one


def _partners(task: Task, places: IntArray, control: Control) -> Iterator[IntArray]:
    """Yield the vertices of the source that candidates put at vertices of the target."""
    found = choose(
        task,
        lambda samples: first_pairs((task.source, task.target), samples, ()),
        COARSE,
        control,
    )
    source, target = task.samples[0].first(_WHOLE_SAMPLES), task.target.at(places)
    for one in cross(task, found, control):
        embedded = one.alignment.embed(source, target, COARSE[-1].weights)
        yield source.vertices[mutual_nearest_points(*embedded)[1]]
