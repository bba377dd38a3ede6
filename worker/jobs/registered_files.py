"""Registered templates as files, and the picture of their components."""

import io
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from broker.contracts import MatchPayload, MatchResult, RegistrationResult
from broker.store import Store
from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.errors import OptionError
from solver.mesh import TriangleMesh
from solver.templates import register_template
from solver.transfer.files import WrittenSurface, write_surface
from worker.jobs.carrying import colors_of_file, solver_map
from worker.jobs.failures import ResultGone, ShapeGone
from worker.jobs.meshes import mesh_of, spectrum_key_of, stored_mesh
from worker.pictures import View, draw_components


def export_registered(
    result: RegistrationResult, job_id: str, specimen: int | None, file_type: str, store: Store
) -> bytes:
    """Return the mean shape, or the template registered to a specimen, as a file.

    Raises
    ------
    ResultGone
        The arrays are no longer kept.
    OptionError
        The template was not registered to this specimen.
    """
    arrays, template = _stored_arrays(job_id, store), _template(result.template, store)
    if specimen is None:
        mean = _surface("mean", arrays["mean"], arrays["faces"], template)
        return write_surface(mean, file_type)
    report = result.specimens[specimen]
    if not report.registered:
        raise OptionError("specimen", f"the template was not registered to it: {report.reason}")
    place = sum(one.registered for one in result.specimens[:specimen])
    name = report.name or report.shape
    positions = arrays["positions"][place]
    return write_surface(_surface(name, positions, arrays["faces"], template), file_type)


def draw_registration(result: RegistrationResult, job_id: str, store: Store) -> bytes:
    """Draw the mean shape and its first principal components as PNG.

    Raises
    ------
    ResultGone
        The arrays are no longer kept.
    """
    arrays = _stored_arrays(job_id, store)
    return draw_components(
        arrays["mean"],
        arrays["faces"],
        arrays["components"],
        arrays["variances"],
        [one.explained for one in result.components],
        f"{result.template_name or 'template'}, {len(arrays['positions'])} specimens",
        View(np.array(result.view)),
    )


def export_match_registered(
    result: MatchResult, payload: MatchPayload, file_type: str, store: Store, control: Control
) -> bytes:
    """Return the source of a match with a dense map, registered to its target, as a file.

    Past the deadline of `control`, folds remain.

    Raises
    ------
    OptionError
        The match has no map of all vertices, or its source is a prototype.
    ShapeGone
        A shape was deleted.
    Cancelled
        Through `control`.
    """
    dense = result.dense
    if dense is None or dense.inverse is None or result.source_kind == "prototype":
        raise OptionError("format", "it needs a match of two shapes with `dense`")
    source, target = (
        _matched_mesh(shape, payload, store) for shape in (payload.source, payload.target)
    )
    forwards = solver_map(dense, dense.inverse, forwards=True)
    found = register_template(source, target, forwards, control)
    rows, faces = rows_of_file(source, found.positions), source.vertex_ids[source.faces]
    named = result.source_name or "source"
    return write_surface(_surface(named, rows, faces, source), file_type)


def rows_of_file(mesh: TriangleMesh, positions: FloatArray) -> FloatArray:
    """Return positions by the vertex numbers of the file.

    Parameters
    ----------
    mesh
        V vertices.
    positions
        (..., V, 3) of its vertices.

    Returns
    -------
    (..., W, 3), those of vertices that no face uses from the first one that is used: OBJ and GLB
    have no positions that are missing.
    """
    ids, own = mesh.numbering
    rows = np.repeat(positions[..., :1, :], mesh.vertex_rows, axis=-2)
    rows[..., ids, :] = positions[..., own, :]
    return rows


def _stored_arrays(job_id: str, store: Store) -> dict[str, npt.NDArray[Any]]:
    stored = store.results.arrays(job_id)
    if stored is None:
        raise ResultGone("the result has expired")
    with np.load(io.BytesIO(stored), allow_pickle=False) as arrays:
        return dict(arrays)


def _template(template: str, store: Store) -> TriangleMesh | None:
    """The mesh of a template; None if it was deleted."""
    try:
        return stored_mesh(template, store.shapes)
    except ShapeGone:
        return None


def _surface(
    name: str, vertices: FloatArray, faces: IntArray, template: TriangleMesh | None
) -> WrittenSurface:
    """A surface with the colours of the template, if it has any and is still there."""
    if template is None or template.colors is None:
        return WrittenSurface(name, vertices, faces, ())
    colors = colors_of_file(template, template.colors)
    # Arrays that an earlier version stored end with the last used vertex.
    colors = replace(colors, values=colors.values[: len(vertices)])
    return WrittenSurface(name, vertices, faces, (colors,))


def _matched_mesh(shape: str, payload: MatchPayload, store: Store) -> TriangleMesh:
    return mesh_of(spectrum_key_of(payload.parameters, shape, store.shapes), shape, store)
