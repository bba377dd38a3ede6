"""The mesh files that the documents take for granted."""

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Final

import isomatch
import numpy as np
import trimesh

from demo import gallery_shapes
from tests.client.shapes import TURN, blob_meshes, moved, write_blobs
from tests.solver.mesh.textures.textured_files import image_file, ramp, textured_glb, zipped_obj
from tests.worker.families import family

SUBDIVISIONS: Final = 2
"""Of the blobs: 162 vertices, as many as the documents need."""


def write_shapes(folder: Path) -> None:
    """``a.off`` and ``b.obj``, which correspond, and another for ``*.off``."""
    write_blobs(folder, SUBDIVISIONS)
    mesh = blob_meshes(SUBDIVISIONS)[0]
    mesh.vertices = mesh.vertices * [1.0, 1.2, 0.8]
    mesh.export(folder / "c.off")


def write_textured(folder: Path) -> None:
    """``standing.glb`` and ``walking.zip``, which correspond and have a texture."""
    first, second = blob_meshes(SUBDIVISIONS)
    directions = trimesh.creation.icosphere(subdivisions=SUBDIVISIONS).vertices
    image = image_file(ramp())
    for name, mesh, along, writer in (
        ("standing.glb", first, directions, textured_glb),
        ("walking.zip", second, directions @ TURN, zipped_obj),
    ):
        coordinates = 0.5 + 0.45 * np.asarray(along)[:, :2]
        vertices = np.asarray(mesh.vertices, dtype=np.float64)
        faces = np.asarray(mesh.faces, dtype=np.int64)
        folder.joinpath(name).write_bytes(writer(vertices, faces, coordinates, image))


def write_class(folder: Path) -> None:
    """``human0.off`` to ``human4.off``, which share their connectivity, and ``stranger.off``."""
    names = [*(f"human{number}" for number in range(5)), "stranger"]
    for name, data in zip(names, family(len(names), first=200), strict=True):
        folder.joinpath(f"{name}.off").write_bytes(data)


def write_parts(folder: Path) -> None:
    """Labels of ``a.off``: ``parts.csv`` of vertices, ``parts.seg`` of faces; ``dressed.glb``."""
    mesh = blob_meshes(SUBDIVISIONS)[0]
    heights = np.asarray(mesh.vertices)[:, 2]
    labels = ["top" if height > 0.3 else "bottom" for height in heights]
    folder.joinpath("parts.csv").write_text("\n".join(["part", *labels, ""]))
    upper = heights[mesh.faces].mean(axis=1) > 0.3
    folder.joinpath("parts.seg").write_text("\n".join(map(str, upper.astype(int).tolist())))
    vertices, faces = np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces)
    coordinates = 0.5 + 0.2 * vertices[:, :2]
    dressed = textured_glb(vertices, faces, coordinates, image_file(ramp()))
    folder.joinpath("dressed.glb").write_bytes(dressed)


def write_specimens(folder: Path) -> None:
    """Specimens of one shape, and two templates with the same landmarks."""
    first, second = blob_meshes(SUBDIVISIONS)
    for name, mesh in (("template", first), ("other", second), ("specimen1", second)):
        mesh.export(folder / f"{name}.ply")
    first.vertices = first.vertices * 1.5
    first.export(folder / "specimen2.ply")
    places = np.asarray(blob_meshes(SUBDIVISIONS)[0].vertices[:40:8], dtype=np.float64)
    labels = ("nasion", "apex", "tip", "left", "right")
    isomatch.write_landmarks(folder / "template.mrk.json", [isomatch.LandmarkSet(labels, places)])
    there = isomatch.LandmarkSet(labels, moved(places))
    isomatch.write_landmarks(folder / "other.fcsv", [there])


WRITERS: Final[Mapping[str, Callable[[Path], None]]] = MappingProxyType(
    {
        "docs/textures.md": write_textured,
        "docs/prototypes.md": write_class,
        "docs/transfer.md": write_parts,
        "docs/landmarks.md": write_specimens,
        "docs/gallery.md": gallery_shapes.write_files,
        "docs/templates.md": write_specimens,
    }
)
"""Who writes what one document has besides."""


def write_files(folder: Path, document: str) -> None:
    """Write the files of a document into a folder."""
    write_shapes(folder)
    if document in WRITERS:
        WRITERS[document](folder)
