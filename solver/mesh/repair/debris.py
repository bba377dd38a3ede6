"""Debris: components too small to matter, such as the loose triangles around a scan."""

import numpy as np

from solver.mesh.normals import triangle_areas
from solver.mesh.repair.soup import TriangleSoup, counted

_DEBRIS = 1e-3
"""Area, in that of the largest component, below which a component is left out: a disc of a
thousandth has the radius 0.018 √area, a tenth of the shortest wavelength of the 100 eigenfunctions
that registrations use. Relative to the largest, so that a surface in equal pieces keeps them."""


def without_debris(soup: TriangleSoup) -> TriangleSoup:
    """Leave out components that are too small to matter, and note what they were."""
    component = soup.component_of_face
    faces = triangle_areas(soup.unit_positions, soup.faces)
    areas = np.bincount(component, weights=faces)
    matters = (areas >= _DEBRIS * areas.max())[component]
    if matters.all():
        return soup
    left_out = len(np.unique(component[~matters]))
    vertices = len(np.unique(soup.faces[~matters]))
    share = 100.0 * faces[~matters].sum() / faces.sum()
    return soup.of_faces(matters).noting(
        f"left out {counted(left_out, 'loose component')} of less than a thousandth of the largest"
        f" one's area: {counted(vertices, 'vertex', 'vertices')},"
        f" {counted(int((~matters).sum()), 'triangle')}, {share:.2g} % of the area"
    )
