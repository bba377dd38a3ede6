"""Checks of what a transfer carries, from the records of shapes and values: before the match."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from isomatch._models import Attributes, Shape
from isomatch._results import Element, TransferKind

_OF_NUMBERS: Final = ("npz", "csv", "ply", "glb")

READ: Final[Mapping[TransferKind, tuple[str, ...]]] = {
    "scalars": (*_OF_NUMBERS, "seg", "txt"),
    "vectors": _OF_NUMBERS,
    "colors": (*_OF_NUMBERS, "obj"),
    "labels": (*_OF_NUMBERS, "obj", "seg", "txt"),
    "skinning": _OF_NUMBERS,
}
"""Formats of files of values; what is not here is carried without one."""

_TEXTURED: Final = ("obj", "glb", "gltf", "zip")

_HOLDING: Final[Mapping[TransferKind, tuple[str, ...]]] = {
    # A mesh in a ZIP file has a format that its record does not tell.
    **{kind: (*READ[kind], "zip") for kind in READ if kind != "colors"},
    "texture": _TEXTURED,
    "uv": _TEXTURED,
}
"""Formats of shapes that may have values of a kind; any may have colours."""

_WORDS: Final[Mapping[TransferKind, str]] = {
    "colors": "colours",
    "skinning": "skinning weights",
    "uv": "texture coordinates",
}


@dataclass(frozen=True)
class Carried:
    """What is carried, from the target if `back`.

    Attributes
    ----------
    kind, back, on, names, points
        As the options say.
    file
        File of values; None for those of the shape itself.
    """

    kind: TransferKind
    back: bool
    file: str | None
    on: Element | None
    names: Sequence[str]
    points: Sequence[int | Mapping[str, Sequence[float]]]

    def check_shapes(self, source: Shape, target: Shape) -> None:
        """Refuse what the shape that it is carried from does not have.

        Raises
        ------
        ValueError
            It does not have it; or the other has no faces.
        """
        shape, onto = (target, source) if self.back else (source, target)
        if self.on == "faces" and onto.kind == "points":
            raise ValueError(f"--on: {onto.name} is a point cloud, which has no faces")
        lacking = self.kind in ("colors", "texture") and not shape.has_colors
        if self.kind in _HOLDING:
            lacking |= shape.file_type not in _HOLDING[self.kind]
        if lacking and self.file is None:
            advice = ": give a file of them" if self.kind in READ else ""
            raise ValueError(f"{shape.name} has no {_WORDS.get(self.kind, self.kind)}{advice}")
        self._check_points(shape)

    def _check_points(self, shape: Shape) -> None:
        for point in self.points:
            vertex = point if isinstance(point, int) else max(point["vertices"])
            if shape.file_vertices is not None and vertex >= shape.file_vertices:
                raise ValueError(
                    f"--point: {vertex} is no vertex of {shape.name}, which has"
                    f" {shape.file_vertices:,}, counted from 0"
                )

    def check_values(self, values: Attributes, source: Shape, target: Shape) -> None:
        """Refuse values of another shape, and a file without values of these names.

        Raises
        ------
        ValueError
            They do not fit; the message tells numbers of rows, or what there is.
        """
        shape = target if self.back else source
        rows = {values.rows, *(one.rows for one in values.attributes)}
        known = (shape.file_vertices, shape.file_faces)
        if None not in known and not rows & set(known):
            raise ValueError(
                f"{values.name} has {values.rows:,} rows, but {shape.name} has"
                f" {shape.file_vertices:,} vertices and {shape.file_faces:,} faces: give a row for"
                " each vertex, or for each face"
            )
        there = [one.name for one in values.attributes]
        missing = [name for name in self.names if name not in there]
        # Names of skinning weights are those of joints, which not all files have.
        if missing and self.kind != "skinning":
            raise ValueError(
                f"--name: {values.name} has nothing called {missing[0]!r}; there are"
                f" {_listed(there)}"
            )


def _listed(names: Sequence[str]) -> str:
    return ", ".join(map(repr, names[:10])) + (f" and {len(names) - 10} more" * (len(names) > 10))
