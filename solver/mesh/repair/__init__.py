"""Mesh repair: from a triangle soup to a surface that can be computed on.

Defects that can be repaired without ambiguity are repaired, with a note. Other defects are only
noted, if distances remain meaningful. A soup without a usable surface is refused with the reason.
Vertices keep the user's numbers.
"""

from solver.mesh.repair.boundary import boundary_of, denser_than
from solver.mesh.repair.debris import without_debris
from solver.mesh.repair.defects import with_defects_noted
from solver.mesh.repair.degenerate import (
    without_repeated_corners,
    without_repeated_faces,
    without_zero_area_faces,
)
from solver.mesh.repair.precision import checked_precision
from solver.mesh.repair.soup import TriangleSoup, check_coordinates, counted, groups_of_equal_rows
from solver.mesh.repair.t_junctions import without_t_junctions
from solver.mesh.repair.triangulation import MOST_CORNERS, triangulated
from solver.mesh.repair.validity import checked_components, checked_surface
from solver.mesh.repair.welding import (
    merge_coincident,
    without_duplicate_parts,
    without_seams,
    without_short_edges,
)
from solver.mesh.repair.winding import with_consistent_winding

_STEPS = (
    checked_precision,
    without_duplicate_parts,
    without_short_edges,
    without_repeated_corners,
    without_seams,
    without_repeated_corners,
    without_zero_area_faces,
    without_repeated_faces,
    checked_surface,
    without_t_junctions,
    without_zero_area_faces,
    without_repeated_faces,
)

__all__ = [
    "MOST_CORNERS",
    "TriangleSoup",
    "boundary_of",
    "check_coordinates",
    "counted",
    "denser_than",
    "groups_of_equal_rows",
    "merge_coincident",
    "repaired",
    "triangulated",
]


def repaired(soup: TriangleSoup) -> TriangleSoup:
    """Repair a triangle soup.

    Parameters
    ----------
    soup
        With faces whose indices are valid.

    Returns
    -------
    TriangleSoup
        Every vertex belongs to a face, every face has three different corners and an area, no
        face occurs twice, and the winding is consistent where the surface is orientable.

    Raises
    ------
    MeshError
        There is no surface in it, or its coordinates cannot be computed with.
    """
    before = len(soup.vertices) + len(soup.merged)
    # Faces without a surface have no say in the extent.
    soup = without_repeated_corners(soup)
    check_coordinates(soup.vertices, soup.faces)
    for step in _STEPS:
        soup = step(soup.compacted())
    soup = soup.compacted()
    unused = before - len(soup.vertices) - len(soup.merged)
    for step in (
        without_debris,
        checked_components,
        with_consistent_winding,
        with_defects_noted,
    ):
        soup = step(soup.compacted())
    if unused and not soup.is_cloud:
        soup = soup.noting(f"dropped {counted(unused, 'vertex', 'vertices')} that no face uses")
    return soup
