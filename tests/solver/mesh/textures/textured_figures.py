"""A generated person in clothes whose picture is a texture: as GLB, and as OBJ in a zip."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from synthetic import articulated, clothed
from tests.solver.mesh.textures.textured_files import MTL, Pixels, image_file, textured_glb, zipped

_SIZE = 512
_EXTENT = 2.2
"""Metres that either half of the picture shows, in height; half of that in width."""


@dataclass(frozen=True, eq=False)
class TexturedPerson:
    """A person in a pose, seen from the front and from the back on the halves of a picture.

    Attributes
    ----------
    vertices, faces
        (V, 3) and (F, 3).
    rest
        (V, 3) where vertices are in the rest pose.
    """

    vertices: FloatArray
    faces: IntArray
    rest: FloatArray

    @property
    def behind(self) -> BoolArray:
        """(F,) bool, whether a face is on the back."""
        a, b, c = (self.rest[self.faces[:, corner]] for corner in range(3))
        behind: BoolArray = np.less(np.cross(b - a, c - a)[:, 2], 0.0)
        return behind

    def coordinates(self) -> FloatArray:
        """(2 V, 2) texture coordinates, v downwards: in front first, then behind."""
        x, y, _ = (self.rest - self._middle()).T / _EXTENT
        front = np.stack([x + 0.25, 0.5 - y], axis=1)
        return np.concatenate([front, front + np.array([0.5, 0.0])])

    def picture(self) -> Pixels:
        """The texture, as painted on the figure at rest."""
        place = (np.arange(_SIZE) + 0.5) / _SIZE
        u, v = np.meshgrid(place, place)
        x = (u % 0.5 - 0.25) * _EXTENT
        depth = np.where(u < 0.5, 0.1, -0.1)
        points = np.stack([x, (0.5 - v) * _EXTENT, depth], axis=2).reshape(-1, 3)
        bounds = np.array([[-1.0, -1.0, -0.2], [1.0, 1.0, 0.2]])  # the middle is the origin
        colors = clothed(np.concatenate([points, bounds]))[:-2]
        return np.rint(255.0 * colors).astype(np.uint8).reshape(_SIZE, _SIZE, 3)

    def glb(self) -> bytes:
        """Vertices repeated along the seam: i and V + i are both vertex i."""
        faces = np.where(self.behind[:, None], self.faces + len(self.vertices), self.faces)
        vertices = np.concatenate([self.vertices, self.vertices])
        return textured_glb(vertices, faces, self.coordinates(), image_file(self.picture()))

    def zip(self) -> bytes:
        """OBJ, material file and image; v counts upwards."""
        upwards = self.coordinates() * [1.0, -1.0] + [0.0, 1.0]
        lines = ["mtllib skin.mtl", "usemtl skin"]
        lines += ["v " + " ".join(map(repr, row)) for row in self.vertices.tolist()]
        lines += ["vt " + " ".join(map(repr, row)) for row in upwards.tolist()]
        shown = np.where(self.behind, len(self.vertices), 0)
        for face, offset in zip(self.faces.tolist(), shown.tolist(), strict=True):
            lines.append("f " + " ".join(f"{v + 1}/{v + 1 + offset}" for v in face))
        files = {"scan/person.obj": "\n".join([*lines, ""]).encode(), "scan/skin.mtl": MTL}
        return zipped(files | {"scan/skin.png": image_file(self.picture())})

    def _middle(self) -> FloatArray:
        middle: FloatArray = 0.5 * (self.rest.min(axis=0) + self.rest.max(axis=0))
        middle[0] = 0.0
        return middle


def textured_person(pose: str, seed: int) -> TexturedPerson:
    """A person of 800 vertices; another seed triangulates it otherwise."""
    figure = articulated("human", pose, 800, seed)
    return TexturedPerson(figure.vertices, figure.faces, figure.rest)


def write_textured(folder: Path) -> tuple[TexturedPerson, TexturedPerson]:
    """Write ``standing.glb`` and ``walking.zip``."""
    standing, walking = textured_person("standing", 0), textured_person("walking", 1)
    (folder / "standing.glb").write_bytes(standing.glb())
    (folder / "walking.zip").write_bytes(walking.zip())
    return standing, walking
