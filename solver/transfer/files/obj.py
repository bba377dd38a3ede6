"""OBJ files with colours of the vertices, or with labels as groups of faces."""

from typing import Any

import numpy as np
import numpy.typing as npt

from solver.arrays import IntArray
from solver.errors import MeshError, TransferError
from solver.mesh.formats import read_obj, read_obj_parts
from solver.transfer.attributes import COLORS_NAME, Attribute
from solver.transfer.files.columns import CHANNELS
from solver.transfer.files.limits import text_column
from solver.transfer.files.names import renamed
from solver.transfer.files.surface import WrittenSurface
from solver.transfer.overlap import FACES


def read_obj_attributes(data: bytes) -> list[Attribute]:
    """Read colours of the vertices, numbers four to six of ``v`` lines, and labels of the faces.

    Labels are the names of their groups (``g``), objects (``o``) and materials (``usemtl``), where
    there are several.

    Raises
    ------
    TransferError
        The bytes are not a complete OBJ file.
    """
    try:
        colors, parts = read_obj(data).colors, read_obj_parts(data)
    except MeshError as error:
        raise TransferError(str(error)) from error
    labels = [Attribute(what, text_column(names), on=FACES) for what, names in parts.items()]
    own = [] if colors is None else [Attribute(COLORS_NAME, colors, CHANNELS[:3])]
    return own + labels


def write_obj(surface: WrittenSurface) -> bytes:
    """Return a surface as OBJ; if it has labels, its faces group by group, ``NAME_LABEL``.

    Words of a group are joined by underscores, one more where two groups would have one name. The
    label of a face without one of its own is that of most of its corners, or of the first.

    Raises
    ------
    TransferError
        It has an attribute that is neither colours nor labels, or several of labels.
    """
    colors, labels = None, None
    for one in surface.attributes:
        if one.name == COLORS_NAME and one.width in (3, 4) and one.on != FACES:
            colors = np.nan_to_num(one.values[:, :3], nan=0.0)
        elif labels is None and one.values.dtype.kind in "iU" and not one.width:
            labels = one
        else:
            raise TransferError(f"OBJ cannot hold {one.name[:40]!r}; choose PLY, GLB, CSV or NPZ")
    table = surface.vertices if colors is None else np.hstack([surface.vertices, colors])
    text = [f"o {'_'.join(surface.name.split()) or 'surface'}"]
    text += [f"v {' '.join(map(repr, row))}" for row in table.tolist()]
    numbers = surface.faces + 1
    if labels is None:
        text += [f"f {a} {b} {c}" for a, b, c in numbers.tolist()]
    else:
        of_faces = labels.values
        if labels.on != FACES:
            of_faces = face_labels(labels.values, surface.faces)
        for group, own in _groups(labels.name, of_faces).items():
            text.append(f"g {group}")
            text += [f"f {a} {b} {c}" for a, b, c in numbers[own].tolist()]
    return ("\n".join(text) + "\n").encode()


def _groups(name: str, labels: npt.NDArray[Any]) -> dict[str, IntArray]:
    """Return the faces of each label by the name of their group."""
    kinds, codes = np.unique(labels, return_inverse=True)
    order = np.argsort(codes, kind="stable")
    faces = np.split(order, np.cumsum(np.bincount(codes))[:-1])
    own = {f"{name}_{label}": one for label, one in zip(kinds.tolist(), faces, strict=True)}
    return renamed(own, (), lambda group: "_".join(group.split()))


def face_labels(labels: npt.NDArray[Any], faces: IntArray) -> npt.NDArray[Any]:
    """Return the label of most corners of each face, (F,); that of the first where all differ."""
    a, b, c = labels[faces].T
    found: npt.NDArray[Any] = np.where(b == c, b, a)
    return found
