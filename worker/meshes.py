"""Meshes as bytes: what the validation of an upload leaves for the jobs that compute on it."""

import io

import numpy as np

from solver.mesh import TriangleMesh, largest_component
from solver.simplification import simplified
from worker.contracts import SpectrumKey


def mesh_to_bytes(mesh: TriangleMesh) -> bytes:
    """Return a mesh as the bytes of an ``.npz`` file, exact to the last bit."""
    stream = io.BytesIO()
    np.savez(
        stream,
        vertices=mesh.vertices,
        faces=mesh.faces,
        vertex_ids=mesh.vertex_ids,
        colors=np.empty((0, 3)) if mesh.colors is None else mesh.colors,
        warnings=np.array(mesh.warnings, dtype=np.str_),
        merged=mesh.merged,
    )
    return stream.getvalue()


def mesh_from_bytes(data: bytes) -> TriangleMesh:
    """Read what :func:`mesh_to_bytes` wrote; nothing in it is ever executed."""
    with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
        return TriangleMesh(
            vertices=arrays["vertices"],
            faces=arrays["faces"],
            vertex_ids=arrays["vertex_ids"],
            colors=arrays["colors"] if len(arrays["colors"]) else None,
            warnings=tuple(str(warning) for warning in arrays["warnings"]),
            # Shapes of before repairs have none.
            merged=arrays["merged"] if "merged" in arrays else np.zeros((0, 2), dtype=np.int64),
        )


def mesh_of(key: SpectrumKey, whole: TriangleMesh) -> TriangleMesh:
    """Return the mesh whose spectrum a key names.

    Parameters
    ----------
    key
        What of the shape is compared.
    whole
        The shape's mesh.
    """
    mesh = largest_component(whole) if key.largest_component else whole
    return mesh if key.simplify is None else simplified(mesh, key.simplify)
