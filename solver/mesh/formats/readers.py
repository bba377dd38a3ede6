"""The formats of mesh files by their endings, but for archives of them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
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


@dataclass(frozen=True)
class MeshFormat:
    """A format of mesh files.

    Parameters
    ----------
    read
        Reads the bytes of a file.
    read_with
        Reads them with the files that they refer to; ``None`` if they refer to none.
    in_zip
        Whether a file of that ending in an archive is the shape: it may be notes or a table beside
        it.
    """

    read: Callable[[bytes], TriangleSoup]
    read_with: Callable[[bytes, Companions], TriangleSoup] | None = None
    in_zip: bool = True


FORMATS: Final[Mapping[str, MeshFormat]] = MappingProxyType(
    {
        "off": MeshFormat(read_off),
        "obj": MeshFormat(read_obj, read_obj),
        "ply": MeshFormat(read_ply),
        "stl": MeshFormat(read_stl),
        "glb": MeshFormat(read_glb, read_glb),
        "gltf": MeshFormat(read_gltf, read_gltf),
        "las": MeshFormat(read_las),
        "laz": MeshFormat(read_las),
        "xyz": MeshFormat(read_xyz),
        "txt": MeshFormat(read_xyz, in_zip=False),
        "csv": MeshFormat(read_xyz, in_zip=False),
    }
)
"""By file extension, lower case, without the dot."""
