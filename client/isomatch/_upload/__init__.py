"""Meshes in memory and in files, as they are uploaded."""

from isomatch._upload.mesh_objects import MeshLike
from isomatch._upload.meshes import (
    FileSource,
    MeshSource,
    attribute_file,
    mesh_file,
    prototype_file,
)
from isomatch._upload.ply import binary_ply

__all__ = [
    "FileSource",
    "MeshLike",
    "MeshSource",
    "attribute_file",
    "binary_ply",
    "mesh_file",
    "prototype_file",
]
