"""Checks of what a transfer carries, from the records of shapes and values: before the match."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from isomatch._models import Attributes, AttributeSummary, Shape
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
        """Refuse values of another shape, and a file without values of this kind or name.

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
        found = [one for one in values.attributes if _may_be(one, self.kind, bool(self.names))]
        there = [one.name for one in values.attributes]
        what = _WORDS.get(self.kind, self.kind)
        if not found:
            raise ValueError(f"{values.name} has no {what}; there are {_listed(there)}")
        named = _joints(found) if self.kind == "skinning" else [one.name for one in found]
        for name in self.names:
            if named and name not in named:
                raise ValueError(
                    f"--name: {values.name} has no {what} called {name!r}; there are"
                    f" {_listed(named)}"
                )


def _may_be(one: AttributeSummary, kind: TransferKind, named: bool) -> bool:
    """Return whether an attribute can be of a kind, as far as its record tells."""
    if kind == "labels":
        # Floats are labels if they are all whole, which the record does not tell.
        return not one.columns
    if one.type == "text":
        return False
    if kind == "colors":
        return len(one.columns) in (3, 4) and (named or one.name == "colors")
    if kind == "scalars":
        return not one.columns
    if kind == "skinning":
        return one.name == "weights" if one.columns else one.on != "faces"
    return bool(one.columns) and (named or one.name not in ("colors", "weights"))


def _joints(found: Sequence[AttributeSummary]) -> list[str]:
    """Names of the joints; none where the record does not tell them."""
    skin = next((one for one in found if one.columns), None)
    if skin is None:
        return [one.name for one in found]
    # Weights of joints without names have numbers as columns, and are called otherwise.
    return [] if all(map(str.isdigit, skin.columns)) else list(skin.columns)


def _listed(names: Sequence[str]) -> str:
    return ", ".join(map(repr, names[:10])) + (f" and {len(names) - 10} more" * (len(names) > 10))
