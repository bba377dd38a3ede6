"""Components of a mesh: their areas, and meshes of some of them."""

from dataclasses import replace

import numpy as np

from solver.arrays import BoolArray, FloatArray
from solver.mesh.normals import triangle_areas
from solver.mesh.triangle_mesh import TriangleMesh


def largest_component(mesh: TriangleMesh) -> TriangleMesh:
    """Keep the connected component of largest area.

    Parameters
    ----------
    mesh
        Any mesh.

    Returns
    -------
    TriangleMesh
        `mesh` itself if it is connected; else the component, with a warning that says how much of
        the area was kept. `vertex_ids` keeps the user's numbers.
    """
    if mesh.components == 1:
        return mesh
    areas = component_areas(mesh)
    largest = np.arange(len(areas)) == np.argmax(areas)
    return of_components(
        mesh,
        largest,
        f"only the largest of {mesh.components} components was kept: "
        f"{100.0 * areas.max() / areas.sum():.3g} % of the area",
    )


def of_components(mesh: TriangleMesh, kept: BoolArray, note: str) -> TriangleMesh:
    """Keep some components.

    Parameters
    ----------
    mesh
        Any mesh.
    kept
        (C,) which of its components.
    note
        Says so in the warnings.

    Returns
    -------
    TriangleMesh
        `vertex_ids` keeps the user's numbers.
    """
    notes = (one for one in mesh.warnings if one != note_of_links(mesh))
    faces = kept[mesh.component_of_vertex[mesh.faces[:, 0]]]
    soup = replace(mesh.soup(), notes=(*notes, note)).of_faces(faces).compacted()
    found = TriangleMesh.of(soup)
    if found.components == 1:
        return found
    return found.with_same_faces(warnings=(*found.warnings, note_of_links(found)))


def component_areas(mesh: TriangleMesh) -> FloatArray:
    """(C,) area of each component."""
    label = mesh.component_of_vertex[mesh.faces[:, 0]]
    areas = np.bincount(label, weights=triangle_areas(mesh.vertices, mesh.faces))
    return areas.astype(np.float64)


def note_of_links(mesh: TriangleMesh) -> str:
    """Warn that the components are linked."""
    areas = component_areas(mesh)
    return (
        f"{mesh.components} components are linked where they are nearest, and matched as one"
        f" surface; `largest_component` takes the largest alone,"
        f" {100.0 * areas.max() / areas.sum():.3g} % of the area"
    )
