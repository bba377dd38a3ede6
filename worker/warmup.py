"""Doing a tiny job of each kind before the first real one, so that forked jobs start warm."""

import gc
import time
from collections.abc import Mapping
from typing import Any

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.mesh import TriangleMesh, read_mesh
from solver.repair.triangulation import triangulated
from solver.shape import Shape
from solver.signature import signature
from solver.similarity import SignatureCollection, dissimilarities, pairs_between
from solver.simplification import simplified
from worker.contracts import (
    DissimilaritiesPayload,
    DissimilarityParameters,
    MatchParameters,
    MatchPayload,
)
from worker.dissimilarities import arrays_of, result_of
from worker.heat_map import draw_matrix
from worker.matches import Side, match_shapes
from worker.meshes import mesh_from_bytes, mesh_to_bytes
from worker.picture import draw_match
from worker.signatures import options_of
from worker.telemetry import logger

log = logger("isomatch.worker")


def warm_up() -> None:
    """Compile and import, in this process, all that jobs will need; forks inherit it.

    A forked job then starts in milliseconds where it would take a good part of a second.
    """
    start = time.perf_counter()
    triangulated(np.eye(5)[:, :3], np.array([5]), np.arange(5))
    mesh = mesh_from_bytes(mesh_to_bytes(read_mesh(_torus_file(), "off")))
    side = Side(simplified(mesh, mesh.n_vertices - 1), None)
    few = MatchParameters(points=24, coarse_points=4, eigenpairs=20)
    for structures in (
        {"descriptor": ("si_hks", "geodesic_histogram")},
        {"metric": ("diffusion", "geodesic"), "descriptor": ("photometric", "conformal_factor")}
        | {"refine": "gmds"},
    ):
        result = match_shapes(side, side, _payload(few, structures), Control())
    draw_match(mesh, mesh, result)
    _compare(mesh)
    # What is here by now stays: a collection in a fork would copy all its pages for nothing.
    gc.collect()
    gc.freeze()
    log.info("warm", seconds=round(time.perf_counter() - start, 3))


def compile_rest() -> None:
    """Compile what few jobs need, to be kept with the rest: nothing that forks would inherit."""
    start = time.perf_counter()
    side = Side(read_mesh(_torus_file(), "off"), None)
    few = MatchParameters(points=8, coarse_points=4, eigenpairs=20)
    for rare in ({"objective": "linf"}, {"metric": "geodesic", "geodesic_method": "exact"}):
        match_shapes(side, side, _payload(few, rare), Control())
    log.info("compiled what is seldom needed", seconds=round(time.perf_counter() - start, 3))


def _payload(parameters: MatchParameters, changes: Mapping[str, Any]) -> MatchPayload:
    changed = MatchParameters.model_validate({**parameters.model_dump(), **changes})
    return MatchPayload(source="warm-up", target="warm-up", parameters=changed)


def _compare(mesh: TriangleMesh) -> None:
    parameters = DissimilarityParameters(first_order_weight=0.1)
    payload = DissimilaritiesPayload(shapes=("a", "b"), labels=("a", "a"), parameters=parameters)
    options = options_of(parameters)
    found = signature(Shape(mesh, eigenpairs=20), options)
    pairs = pairs_between(2, 0, 1)
    collection = SignatureCollection.of([found, found], options.points)
    values = dissimilarities(collection, pairs, options).costs
    result = result_of(payload, values, {})
    arrays_of(result, values)
    result.model_dump_json()
    draw_matrix(result, ("a", "b"))


def _torus_file() -> bytes:
    """A painted torus whose tube gets wider, as an OFF file: it has no symmetry to speak of."""
    vertices, faces = _torus(24, 12)
    colors = 0.5 + 0.25 * vertices
    lines = ["COFF", f"{len(vertices)} {len(faces)} 0"]
    lines += [" ".join(map(str, row)) for row in np.hstack([vertices, colors]).tolist()]
    lines += ["3 " + " ".join(map(str, face)) for face in faces.tolist()]
    return "\n".join(lines).encode()


def _torus(around: int, across: int) -> tuple[FloatArray, IntArray]:
    i, j = np.divmod(np.arange(around * across), across)
    u, v = 2.0 * np.pi * i / around, 2.0 * np.pi * j / across
    tube = 0.3 + 0.1 * np.sin(u) + 0.05 * np.cos(2.0 * u + 1.0) + 0.03 * np.cos(v)
    radius = 1.0 + tube * np.cos(v)
    vertices = np.stack([radius * np.cos(u), radius * np.sin(u), tube * np.sin(v)], axis=1)
    east = (i + 1) % around * across
    north = (j + 1) % across
    corners = np.stack([i * across + j, east + j, east + north, i * across + north], axis=1)
    return vertices, np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])
