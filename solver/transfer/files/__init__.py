"""Files of attributes: NPZ and CSV, and PLY, OBJ and GLB with the surface; lists of labels as text.

Row i is vertex i, or face i, of the shape's file in NPZ, CSV and lists. Files with the surface have
its vertices in the same order, and its triangles; OBJ with labels has these group by group, and GLB
with values of faces or with a texture repeats vertices.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType

from solver.errors import TransferError
from solver.transfer.attributes import Attribute
from solver.transfer.files.csv_table import read_csv, write_csv
from solver.transfer.files.glb import read_glb_attributes
from solver.transfer.files.glb_writing import write_glb
from solver.transfer.files.label_list import read_label_list
from solver.transfer.files.limits import checked
from solver.transfer.files.npz import read_npz, write_npz
from solver.transfer.files.obj import read_obj_attributes, write_obj
from solver.transfer.files.ply import read_ply_attributes, write_ply
from solver.transfer.files.surface import WrittenSurface
from solver.transfer.files.textured import write_obj_archive, write_textured_glb, write_textured_obj

_READERS: Mapping[str, Callable[[bytes], list[Attribute]]] = MappingProxyType(
    {
        "npz": read_npz,
        "csv": read_csv,
        "ply": read_ply_attributes,
        "obj": read_obj_attributes,
        "glb": read_glb_attributes,
        "seg": read_label_list,
        "txt": read_label_list,
    }
)

ATTRIBUTE_FORMATS: tuple[str, ...] = tuple(_READERS)
"""File extensions of attribute files, lower case, without the dot."""


def read_attributes(data: bytes, file_type: str) -> tuple[Attribute, ...]:
    """Read an attribute file.

    Parameters
    ----------
    data
        Bytes of the file.
    file_type
        One of `ATTRIBUTE_FORMATS`.

    Raises
    ------
    TransferError
        The format is unknown, or the file is not a sound one of it with attributes.
    """
    if file_type not in _READERS:
        raise TransferError(f"{file_type[:20]!r} files have no attributes that are read")
    try:
        return checked(_READERS[file_type](data))
    except MemoryError:
        raise TransferError("the file is too large to be read in the memory there is") from None


def write_surface(surface: WrittenSurface, file_type: str) -> bytes:
    """Write a surface with its attributes.

    Parameters
    ----------
    surface
        The surface.
    file_type
        "ply", "obj" or "glb".

    Raises
    ------
    TransferError
        The format cannot hold an attribute.
    """
    if file_type == "glb":
        return write_glb([surface])
    return {"ply": write_ply, "obj": write_obj}[file_type](surface)


__all__ = [
    "ATTRIBUTE_FORMATS",
    "WrittenSurface",
    "read_attributes",
    "write_csv",
    "write_glb",
    "write_npz",
    "write_obj_archive",
    "write_surface",
    "write_textured_glb",
    "write_textured_obj",
]
