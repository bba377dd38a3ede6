"""Triangle meshes: reading, repair, components, normals, curvature, simplification, projection."""

from solver.mesh.components import component_areas, largest_component, of_components
from solver.mesh.edges import components_of, non_manifold_vertices
from solver.mesh.file_contents import mapped_surface, textured_surface
from solver.mesh.mean_curvature import mean_curvature_measures
from solver.mesh.nearest_points import (
    descend,
    nearby_vertex,
    nearest_in_fan,
    nearest_in_triangle,
    project,
)
from solver.mesh.normals import face_normals, triangle_areas, vertex_normals
from solver.mesh.reading import MESH_FORMATS, read_mesh, triangle_mesh
from solver.mesh.rotations import nearest_rotations
from solver.mesh.simplification import simplified
from solver.mesh.surface_tree import SurfaceTree, nearest_triangles, surface_tree
from solver.mesh.triangle_mesh import TriangleMesh

__all__ = [
    "MESH_FORMATS",
    "SurfaceTree",
    "TriangleMesh",
    "component_areas",
    "components_of",
    "descend",
    "face_normals",
    "largest_component",
    "mapped_surface",
    "mean_curvature_measures",
    "nearby_vertex",
    "nearest_in_fan",
    "nearest_in_triangle",
    "nearest_rotations",
    "nearest_triangles",
    "non_manifold_vertices",
    "of_components",
    "project",
    "read_mesh",
    "simplified",
    "surface_tree",
    "textured_surface",
    "triangle_areas",
    "triangle_mesh",
    "vertex_normals",
]
