"""Stored meshes: as bytes, from the store, simplified and cached."""

import io
import zipfile
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from broker.contracts import SpectrumKey, SpectrumParameters, spectrum_key
from broker.store import Shapes, Store
from solver.arrays import IntArray, npz_bytes
from solver.mesh import TriangleMesh, largest_component, simplified
from worker.jobs.failures import ShapeGone, content_of


def mesh_to_bytes(mesh: TriangleMesh) -> bytes:
    """Return a mesh as the bytes of an ``.npz`` file, without loss.

    A mesh that can be uploaded takes less than the largest value of Redis.
    """
    arrays = {
        "vertices": mesh.vertices,
        "faces": _compact(mesh.faces),
        "vertex_ids": _compact(mesh.vertex_ids),
        "colors": np.empty((0, 3)) if mesh.colors is None else mesh.colors,
        "warnings": np.array(mesh.warnings, dtype=np.str_),
        "merged": _compact(mesh.merged),
        "face_ids": np.empty(0) if mesh.face_ids is None else _compact(mesh.face_ids),
        "file_rows": np.array(mesh.file_rows or (), dtype=np.int64),
        "is_cloud": np.array(mesh.is_cloud),
    }
    return npz_bytes(arrays, zipfile.ZIP_STORED)


def mesh_from_bytes(data: bytes) -> TriangleMesh:
    """Read a mesh that :func:`mesh_to_bytes` wrote; pickled objects are refused."""
    with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
        return TriangleMesh(
            vertices=arrays["vertices"],
            faces=arrays["faces"].astype(np.int64),
            vertex_ids=arrays["vertex_ids"].astype(np.int64),
            colors=arrays["colors"] if len(arrays["colors"]) else None,
            warnings=tuple(str(warning) for warning in arrays["warnings"]),
            is_cloud="is_cloud" in arrays and bool(arrays["is_cloud"]),
            # Shapes that were stored before meshes were repaired do not have it.
            merged=(
                arrays["merged"].astype(np.int64)
                if "merged" in arrays
                else np.zeros((0, 2), dtype=np.int64)
            ),
            **_numbering(arrays),
        )


def stored_mesh(shape: str, shapes: Shapes) -> TriangleMesh:
    """Return the mesh of a shape.

    Raises
    ------
    ShapeGone, ShapeLost
        The shape was deleted, or its content is lost.
    """
    with content_of(shape):
        stored = shapes.mesh(shape)
    if stored is None:
        raise ShapeGone(shape)
    return mesh_from_bytes(stored)


def spectrum_key_of(parameters: SpectrumParameters, shape: str, shapes: Shapes) -> SpectrumKey:
    """Return the key of a shape's spectrum.

    Raises
    ------
    ShapeGone
        The shape was deleted.
    """
    record = shapes.get(shape)
    if record is None:
        raise ShapeGone(shape)
    return spectrum_key(parameters, record)


def mesh_of(key: SpectrumKey, shape: str, store: Store) -> TriangleMesh:
    """Return the mesh whose spectrum a key names; a simplified mesh is cached.

    Parameters
    ----------
    key
        Key of the spectrum.
    shape
        Id of the shape.
    store
        Its store, with the cache.

    Raises
    ------
    ShapeGone, ShapeLost
        The shape was deleted, or its content is lost.
    """
    if key.simplify is not None:
        cached = store.spectra.get(key.mesh_name)
        if cached is not None:
            return mesh_from_bytes(cached)
    mesh = stored_mesh(shape, store.shapes)
    if key.largest_component:
        mesh = largest_component(mesh)
    if key.simplify is not None:
        mesh = simplified(mesh, key.simplify)
        store.spectra.put(key.mesh_name, mesh_to_bytes(mesh))
    return mesh


def _numbering(arrays: Mapping[str, npt.NDArray[Any]]) -> dict[str, Any]:
    """Numbers of the file's faces; shapes that were stored before faces were numbered have none."""
    if "file_rows" not in arrays or not len(arrays["file_rows"]):
        return {}
    vertices, faces = arrays["file_rows"].tolist()
    # Files of points alone have no faces that triangles could be part of.
    ids = arrays["face_ids"].astype(np.int64) if len(arrays["face_ids"]) else None
    return {"face_ids": ids, "file_rows": (vertices, faces)}


def _compact(numbers: IntArray) -> IntArray | npt.NDArray[np.int32]:
    return numbers.astype(np.int32) if numbers.max(initial=0) < 2**31 else numbers
