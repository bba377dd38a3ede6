"""Triangle meshes: reading, repair, colours and textures, normals, simplification."""

from solver.mesh.file_contents import mapped_surface, textured_surface
from solver.mesh.normals import face_normals, vertex_normals
from solver.mesh.simplification import simplified
from solver.mesh.triangle_mesh import (
    MESH_FORMATS,
    TriangleMesh,
    largest_component,
    read_mesh,
    triangle_areas,
    triangle_mesh,
)

__all__ = [
    "MESH_FORMATS",
    "TriangleMesh",
    "face_normals",
    "largest_component",
    "mapped_surface",
    "read_mesh",
    "simplified",
    "textured_surface",
    "triangle_areas",
    "triangle_mesh",
    "vertex_normals",
]
