"""From triangles as a file holds them to a surface that can be computed on.

What can be repaired without doubt is, with a note that says so; what cannot is refused with the
reason, or noted where it leaves distances meaningful. The surface keeps the user's vertex numbers.
"""

from solver.mesh.repair.degenerate import (
    without_flat_faces,
    without_repeated_corners,
    without_repeated_faces,
)
from solver.mesh.repair.edges import edges_of
from solver.mesh.repair.findings import pinched_vertices, with_findings
from solver.mesh.repair.junctions import without_junctions
from solver.mesh.repair.orientation import oriented
from solver.mesh.repair.precision import checked_precision
from solver.mesh.repair.proximity import border_of, crowded
from solver.mesh.repair.soup import TriangleSoup, check_coordinates, counted, groups_of_equal_rows
from solver.mesh.repair.triangulation import MOST_CORNERS, triangulated
from solver.mesh.repair.welding import without_copies, without_seams, without_tiny_edges

_STEPS = (
    without_repeated_corners,
    checked_precision,
    without_copies,
    without_tiny_edges,
    without_repeated_corners,
    without_seams,
    without_repeated_corners,
    without_flat_faces,
    without_repeated_faces,
    without_junctions,
    without_flat_faces,
    without_repeated_faces,
    oriented,
    with_findings,
)

__all__ = [
    "MOST_CORNERS",
    "TriangleSoup",
    "border_of",
    "check_coordinates",
    "counted",
    "crowded",
    "edges_of",
    "groups_of_equal_rows",
    "pinched_vertices",
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
        face occurs twice, neighbours are oriented alike where the surface has two sides.

    Raises
    ------
    MeshError
        There is no surface in it, or its coordinates cannot be computed with.
    """
    check_coordinates(soup.vertices, soup.faces)
    before = len(soup.vertices) + len(soup.merged)
    for step in _STEPS:
        soup = step(soup.compacted())
    soup = soup.compacted()
    unused = before - len(soup.vertices) - len(soup.merged)
    if unused:
        soup = soup.noting(f"dropped {counted(unused, 'vertex', 'vertices')} of no face")
    return soup
