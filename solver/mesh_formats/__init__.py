"""Mesh files as arrays, one module per format.

Every reader keeps the file's own vertex numbering and refuses what it cannot read in full: a file
that is cut off or contradicts itself raises `MeshError`, it never yields part of a shape.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType

from solver.mesh_formats.archive import read_zip
from solver.mesh_formats.gltf import read_glb, read_gltf
from solver.mesh_formats.obj import read_obj
from solver.mesh_formats.off import read_off
from solver.mesh_formats.ply import read_ply
from solver.mesh_formats.stl import read_stl
from solver.repair.soup import TriangleSoup

READERS: Mapping[str, Callable[[bytes], TriangleSoup]] = MappingProxyType(
    {
        "off": read_off,
        "obj": read_obj,
        "ply": read_ply,
        "stl": read_stl,
        "glb": read_glb,
        "gltf": read_gltf,
        "zip": read_zip,
    }
)
"""Reader of each format by file extension, lower case, without the dot."""

__all__ = ["READERS", "TriangleSoup"]
