"""Meshes of a measurement by size: one of a file, or generated bodies."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

from solver.mesh import TriangleMesh, read_mesh, triangle_mesh
from synthetic import human


def size_options(parser: ArgumentParser, sizes: tuple[int, ...]) -> None:
    """Add the options of :func:`meshes_by_size`."""
    parser.add_argument("--mesh", type=Path, help="a mesh; by default generated bodies")
    parser.add_argument("--most", type=int, default=sizes[-1], help="greatest number of vertices")


def meshes_by_size(
    parser: ArgumentParser, arguments: Namespace, sizes: tuple[int, ...]
) -> list[TriangleMesh]:
    """Mesh that the command line names, or bodies of those sizes, ascending, that it allows."""
    if arguments.mesh:
        return [read_mesh(arguments.mesh.read_bytes(), arguments.mesh.suffix[1:].lower())]
    if arguments.most < sizes[0]:
        parser.error(f"--most: the smallest body has {sizes[0]} vertices")
    bodies = (human(resolution=size) for size in sizes if size <= arguments.most)
    return [triangle_mesh(body.vertices, body.faces) for body in bodies]
