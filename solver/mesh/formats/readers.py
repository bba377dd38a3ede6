"""The formats of mesh files by their endings, but for archives of them."""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Final

from solver.mesh.formats.companions import Companions
from solver.mesh.formats.gltf import read_glb, read_gltf
from solver.mesh.formats.las import read_las
from solver.mesh.formats.obj import read_obj
from solver.mesh.formats.off import read_off
from solver.mesh.formats.ply import read_ply
from solver.mesh.formats.stl import read_stl
from solver.mesh.formats.xyz import read_xyz
from solver.mesh.repair import TriangleSoup

FORMATS: Final[Mapping[str, Callable[[bytes], TriangleSoup]]] = MappingProxyType(
    {
        "off": read_off,
        "obj": read_obj,
        "ply": read_ply,
        "stl": read_stl,
        "glb": read_glb,
        "gltf": read_gltf,
        "las": read_las,
        "laz": read_las,
        "xyz": read_xyz,
        "txt": read_xyz,
        "csv": read_xyz,
    }
)
"""Readers of the bytes of a file by its extension, lower case, without the dot."""

WITH_COMPANIONS: Final[Mapping[str, Callable[[bytes, Companions], TriangleSoup]]] = (
    MappingProxyType({"obj": read_obj, "glb": read_glb, "gltf": read_gltf})
)
"""Readers of files that refer to others, with these."""

TABLES: Final = ("txt", "csv")
"""Files that are not the shape of an archive: they may be notes or a table beside it."""
