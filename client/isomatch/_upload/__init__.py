"""Meshes in memory and in files, as they are uploaded."""

from isomatch._upload.meshes import (
    FileSource,
    MeshLike,
    MeshSource,
    attribute_file,
    binary_ply,
    mesh_file,
    prototype_file,
)

__all__ = [
    "FileSource",
    "MeshLike",
    "MeshSource",
    "attribute_file",
    "binary_ply",
    "mesh_file",
    "prototype_file",
]
