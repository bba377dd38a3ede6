"""Mesh files as arrays, one module per format.

Every reader keeps the file's own vertex numbering and refuses what it cannot read in full: a file
that is cut off or contradicts itself raises `MeshError`, it never yields part of a shape.

trimesh 5.2 reads these formats, but neither numbers vertices as the file does (OBJ: repeated along
seams and for every material) nor refuses partial files (OBJ, OFF and PLY text cut off, glTF with
negative indices or counts), and reads sparse, quantised and Draco-compressed glTF as if they were
plain. It also loses vertex colours (OFF), polygons (PLY binary), texture transforms, wrap modes and
all texture coordinates but the first (glTF), and takes 18 s for a GLB file of 20,000 nodes.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType

from solver.mesh.formats.archive import mesh_in_zip, read_zip
from solver.mesh.formats.gltf import read_glb_with
from solver.mesh.formats.gltf_data import GltfData
from solver.mesh.formats.gltf_scene import MODES, scene_of, vertex_set
from solver.mesh.formats.gltf_skins import check_joints, influences, joint_nodes
from solver.mesh.formats.obj import read_obj, read_obj_coordinates, read_obj_parts
from solver.mesh.formats.ply import PlyColumns, ply_columns
from solver.mesh.formats.ply_data import Element, Property, binary_columns
from solver.mesh.formats.readers import FORMATS
from solver.mesh.repair import TriangleSoup

READERS: Mapping[str, Callable[[bytes], TriangleSoup]] = MappingProxyType(
    {**FORMATS, "zip": read_zip}
)
"""Reader of each format by file extension, lower case, without the dot."""

__all__ = [
    "MODES",
    "READERS",
    "Element",
    "GltfData",
    "PlyColumns",
    "Property",
    "binary_columns",
    "check_joints",
    "influences",
    "joint_nodes",
    "mesh_in_zip",
    "ply_columns",
    "read_glb_with",
    "read_obj",
    "read_obj_coordinates",
    "read_obj_parts",
    "scene_of",
    "vertex_set",
]
