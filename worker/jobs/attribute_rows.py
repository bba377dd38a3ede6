"""Rows of attribute files: of the vertices or of the faces of the shape's file."""

from collections.abc import Sequence
from dataclasses import replace

from broker.contracts import TransferPayload
from solver.errors import OptionError
from solver.mesh import TriangleMesh
from solver.mesh.repair import counted
from solver.transfer import FACES, SKINNING, VERTICES, Attribute


def with_rows_known(
    given: Sequence[Attribute], mesh: TriangleMesh, payload: TransferPayload
) -> tuple[Attribute, ...]:
    """Tell attributes of vertices from those of faces by their numbers of rows.

    Parameters
    ----------
    given
        Attributes of a file. Where it does not say what their rows are of, and the shape has as
        many faces as vertices, they are of vertices.
    mesh
        The shape that they are of.
    payload
        The transfer.

    Raises
    ------
    OptionError
        A number of rows is none of the two, or skinning weights are of faces.
    """
    # Shapes of earlier versions do not know the faces of their files.
    vertices, faces = mesh.vertex_rows, mesh.file_rows and mesh.file_rows[1]
    rows = {VERTICES: vertices, FACES: faces}
    found = []
    for one in given:
        possible = (VERTICES, FACES) if one.on is None else (one.on,)
        fitting = [on for on in possible if len(one.values) == rows[on]]
        if not fitting:
            of_faces = "unknown faces" if faces is None else counted(faces, "face")
            has = f"{counted(vertices, 'vertex', 'vertices')} and {of_faces}"
            raise OptionError("attributes", _misfit(one, has, mesh, payload.source))
        if fitting[0] == FACES and payload.what == SKINNING:
            raise OptionError("attributes", "skinning weights are of vertices, not of faces")
        found.append(replace(one, on=fitting[0]))
    return tuple(found)


def _misfit(one: Attribute, has: str, mesh: TriangleMesh, shape: str) -> str:
    """What is wrong with a number of rows, and what to do about it."""
    of, count = f" of {one.on}" if one.on else "", len(one.values)
    advice = "give a row for every vertex, or for every face, in the order of that file"
    if mesh.file_rows is None:
        advice = "for values of faces, delete the shape, and upload it again"
    elif count == 3 * mesh.n_faces:
        advice = 'values of corners are not carried; "uv" carries texture coordinates'
    there = f"there is {count} row" if count == 1 else f"there are {count} rows"
    return f"{there}{of}, and the file of shape {shape} has {has}; {advice}"
