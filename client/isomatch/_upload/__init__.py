"""Meshes in memory and in files, as they are uploaded."""

from isomatch._upload.meshes import (
    MeshFile,
    MeshLike,
    MeshSource,
    attribute_file,
    binary_ply,
    mesh_file,
    name_of,
)

__all__ = [
    "MeshFile",
    "MeshLike",
    "MeshSource",
    "attribute_file",
    "binary_ply",
    "mesh_file",
    "name_of",
]
