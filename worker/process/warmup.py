"""Warm-up: one small job of each kind, so that forked jobs find all functions compiled."""

import gc
import time
from collections.abc import Callable, Mapping
from typing import Any, Final

import numpy as np

from broker.contracts import (
    DissimilaritiesPayload,
    DissimilarityParameters,
    MatchParameters,
    MatchPayload,
)
from broker.telemetry import logger
from solver.control import Control, iterate
from solver.gmds import SurfacePoints, refine_by_gmds
from solver.labelling import LabellingProblem
from solver.matching import MatchOptions
from solver.mesh import TriangleMesh, read_mesh, simplified, triangle_mesh
from solver.mesh.formats import Element, Property, binary_columns
from solver.optimisation.dual_decomposition import DualDecomposition
from solver.optimisation.exact import m_best_solutions
from solver.optimisation.minimum_cut import minimum_cut
from solver.optimisation.primal import IteratedLocalSearch
from solver.prototype import (
    PrototypeOptions,
    connected_examples,
    learn_prototype,
    match_prototype,
    prototype_from_bytes,
    prototype_to_bytes,
)
from solver.registration import DenseCorrespondence, register
from solver.shape import Shape
from solver.similarity import (
    SignatureCollection,
    SimilarityOptions,
    dissimilarities,
    pairs_between,
    signature,
)
from solver.templates import register_template, shape_statistics, surface_distance
from solver.transfer import carry_landmarks, place_landmarks
from worker.jobs import (
    MatchInput,
    arrays_of,
    match_shapes,
    mesh_from_bytes,
    mesh_to_bytes,
    options_of,
    result_of,
    torus_file,
)
from worker.pictures import draw_match, hypothesis_of

log = logger("isomatch.worker")

_SLOW: Final = 2.0
"""Seconds from which on a step is told: it was compiled."""

_ITERATIONS = 150
"""Iterations of the dual decomposition, so many that it fuses correspondences."""


def warm_up() -> None:
    """Compile and import what jobs need, in the process that forks them.

    A forked job then starts in milliseconds instead of a good part of a second.
    """
    start = time.perf_counter()
    # What has been imported stays: a search for garbage among it would find next to none.
    gc.freeze()
    log.info("warming up; where nothing is compiled yet, this takes minutes")
    mesh = mesh_from_bytes(mesh_to_bytes(read_mesh(torus_file(), "off")))
    steps: tuple[tuple[str, Callable[[TriangleMesh], None]], ...] = (
        ("reading", _read),
        ("matching", _match),
        ("dense maps", _map),
        ("comparing", _compare),
        ("learning", _learn),
        ("registering", _register),
        ("proving", _decompose),
    )
    for number, (name, step) in enumerate(steps, 1):
        begun = time.perf_counter()
        step(mesh)
        seconds = time.perf_counter() - begun
        if seconds > _SLOW:
            log.info(
                "compiled", what=name, step=f"{number} of {len(steps)}", seconds=round(seconds, 1)
            )
    # Garbage collection in a fork would copy the pages of all objects that exist now.
    gc.collect()
    gc.freeze()
    gc.enable()
    log.info("warm", seconds=round(time.perf_counter() - start, 3))


def _read(mesh: TriangleMesh) -> None:
    binary_columns((Element("face", 1, {"vertex_indices": Property("i4", "u1")}),), b"\0", "<")
    simplified(mesh, mesh.n_vertices - 1)


def _match(mesh: TriangleMesh) -> None:
    source, target = _two(mesh)
    structures = {
        "metric": ("diffusion", "geodesic"),
        "descriptor": ("photometric", "conformal_factor", "si_hks", "geodesic_histogram"),
        "orientation": False,
    }
    few = MatchParameters(points=24, coarse_points=4, eigenpairs=20)
    inputs = MatchInput(source, None), MatchInput(target, None)
    result = match_shapes(*inputs, _payload(few, structures), Control())
    draw_match(source, target, hypothesis_of(result, None))


def _map(mesh: TriangleMesh) -> None:
    source, target = _two(mesh)
    found = register(Shape(source), Shape(target), (), _one_of_each())
    assert found is not None
    dense = found.dense(Control())
    assert dense.inverse is not None
    placed = place_landmarks((None,), source.vertices[:1], source)
    carry_landmarks(placed.points, (dense, dense.inverse), source, target)
    refine_by_gmds(found, np.arange(3), _one_of_each())
    # By which candidates are crossed in doubt.
    minimum_cut(np.zeros(1, dtype=np.int64), np.ones(1, dtype=np.int64), np.ones(1), 0, 1)


def _two(mesh: TriangleMesh) -> tuple[TriangleMesh, TriangleMesh]:
    # Stretched: a match of a shape with itself is optimal before any bound is computed.
    stretched = triangle_mesh(mesh.vertices * [1.0, 1.3, 0.8], mesh.faces, mesh.colors)
    return simplified(mesh, mesh.n_vertices - 1), stretched


def _one_of_each() -> Control:
    """Past its deadline, a registration tries one candidate: many would load nothing more."""
    return Control(deadline=time.monotonic())


def compile_rest() -> None:
    """Compile what few jobs need, for the cache on disk; run when the image is built."""
    start = time.perf_counter()
    shape = MatchInput(read_mesh(torus_file(), "off"), None)
    few = MatchParameters(points=8, coarse_points=4, eigenpairs=20)
    match_shapes(shape, shape, _payload(few, {"objective": "linf"}), Control())
    points = np.random.default_rng(0).normal(size=(200, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    read_mesh("\n".join(" ".join(map(str, place)) for place in points.tolist()).encode(), "xyz")
    log.info("compiled the rest", seconds=round(time.perf_counter() - start, 3))


def _payload(parameters: MatchParameters, changes: Mapping[str, Any]) -> MatchPayload:
    changed = MatchParameters.model_validate({**parameters.model_dump(), **changes})
    return MatchPayload(source="warm-up", target="warm-up", parameters=changed)


def _compare(mesh: TriangleMesh) -> None:
    parameters = DissimilarityParameters(first_order_weight=0.1)
    payload = DissimilaritiesPayload(shapes=("a", "b"), labels=("a", "a"), parameters=parameters)
    options = options_of(SimilarityOptions, parameters)
    found = signature(Shape(mesh, eigenpairs=20), options)
    pairs = pairs_between(2, 0, 1)
    collection = SignatureCollection.of([found, found], options.points)
    values = dissimilarities(collection, pairs, options).costs
    result = result_of(payload, values, {})
    arrays_of(result, values)
    result.model_dump_json()


def _learn(mesh: TriangleMesh) -> None:
    shape = Shape(mesh, eigenpairs=20)
    learning = PrototypeOptions(points=12, components=1)
    examples = connected_examples([shape, shape], learning).examples
    prototype = prototype_from_bytes(prototype_to_bytes(learn_prototype(examples, learning)))
    options = MatchOptions(points=12, coarse_points=4)
    match_prototype(prototype, shape, options, _one_of_each())


def _register(mesh: TriangleMesh) -> None:
    """Register a mesh to itself by a map with a fold."""
    images = np.arange(mesh.n_vertices)
    images[mesh.faces[0, 0]] = mesh.faces[0, 1]
    points = SurfacePoints.at_vertices(mesh, images)
    corners = mesh.vertex_ids[mesh.faces[points.faces]]
    dense = DenseCorrespondence(
        mesh.vertex_ids, mesh.vertex_ids[images], corners, points.barycentric
    )
    positions = register_template(mesh, mesh, dense).positions
    surface_distance(positions, mesh, mesh)
    shape_statistics(np.stack([positions, mesh.vertices]))


def _decompose(mesh: TriangleMesh) -> None:
    """Bound a problem that cannot be enumerated, as few matches need: one of random distances."""
    random = np.random.default_rng(0)
    places = random.normal(size=(2, 12, 3))
    source, target = (np.linalg.norm(x[:, None] - x[None], axis=2) for x in places)
    pairs = np.ascontiguousarray(np.argwhere(np.ones((12, 12), dtype=np.bool_)))
    for gamma in (np.inf, 1.0):
        problem = LabellingProblem(pairs, np.zeros(len(pairs)), source, target, 1.0, gamma)
        state = iterate(DualDecomposition(problem), _ITERATIONS, Control()).state
        known, costs = state.incumbent.partners, state.reparametrised_costs()
        iterate(IteratedLocalSearch(problem, known), 1, Control())
        m_best_solutions(problem, known=known, reparametrised=costs, node_limit=1)
