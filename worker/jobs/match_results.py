"""Results of matches: the document, and the same as arrays."""

import gzip
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from broker import contracts
from broker.contracts import MatchPayload, MatchResult, MatchSummary, is_prototype
from solver.arrays import FloatArray, npz_bytes
from solver.gmds import GmdsRefinement
from solver.matching import Correspondence, GromovHausdorff, Match, Overlap, SampleProof, relation
from solver.mesh import TriangleMesh
from solver.registration import Confidence, DenseCorrespondence

_DECIMALS = 4
"""Decimals of barycentric coordinates of dense maps: far less than an edge, at half the size."""


def document_of(
    found: Match,
    payload: MatchPayload,
    target: TriangleMesh,
    refinement: contracts.Refinement | None = None,
) -> MatchResult:
    """Return the result document of a match onto `target`."""
    best = found.best
    return MatchResult(
        source=payload.source,
        source_kind="prototype" if is_prototype(payload.source) else "shape",
        target=payload.target,
        parameters=payload.parameters,
        correspondences=_pairs(best),
        distortion=_distortion(best),
        gromov_hausdorff=best.distortion.gromov_hausdorff,
        energy=best.energy,
        lower_bound=found.lower_bound,
        gap=found.gap,
        certified=found.certified,
        confidence=None if found.confidence is None else confidence_of(found.confidence),
        alternatives=tuple(
            contracts.Alternative(
                relation=_relation(best, other, target),
                energy=other.energy,
                correspondences=_pairs(other),
                distortion=_distortion(other),
            )
            for other in found.alternatives
        ),
        levels=tuple(
            contracts.Level.model_validate(level, from_attributes=True) for level in found.levels
        ),
        proof=None if found.proof is None else _proof(found.proof),
        gromov_hausdorff_distance=_gromov_hausdorff(found.gromov_hausdorff_distance),
        overlap=None if found.overlap is None else _overlap(found.overlap),
        unmatched=tuple(best.unmatched.tolist()),
        dense=None if found.dense is None else _dense(found.dense),
        refinement=refinement,
        misfit=found.misfit,
        warnings=found.warnings,
        timings=dict(found.timings),
    )


def refinement_of(
    found: GmdsRefinement, source: TriangleMesh, target: TriangleMesh
) -> contracts.Refinement:
    """Return the refined points, named by the vertices of the two files."""
    corners = target.vertex_ids[target.faces[found.points.faces]]
    # Rounding may leave a weight slightly outside [0, 1].
    weights = np.clip(found.points.barycentric, 0.0, 1.0)
    rows = zip(
        source.vertex_ids[found.source].tolist(),
        corners.tolist(),
        weights.tolist(),
        strict=True,
    )
    return contracts.Refinement(
        hypothesis=found.hypothesis,
        stress=found.stress,
        initial_stress=found.initial_stress,
        status=found.status.value,
        points=tuple(
            contracts.RefinedPoint(source=vertex, vertices=tuple(three), weights=tuple(shares))
            for vertex, three, shares in rows
        ),
    )


def arrays_of(result: MatchResult) -> bytes:
    """Return a result as the bytes of an ``.npz`` file without pickled objects.

    `source`, `target` (n,) int64 and `costs` (n,) float64 of the pairs, `unmatched` (u,) int64;
    `dense_source`, `dense_target` (K,) int64, `dense_faces` (K, 3) int64, `dense_barycentric`
    (K, 3) float64, the same of the inverse as `inverse_target`, `inverse_source` (L,),
    `inverse_faces` and `inverse_barycentric` (L, 3), and `refined_vertices` (n, 3) int64,
    `refined_weights` (n, 3) float64 if the result has them.
    """
    arrays = {
        "source": np.array([pair.source for pair in result.correspondences], dtype=np.int64),
        "target": np.array([pair.target for pair in result.correspondences], dtype=np.int64),
        "costs": np.array([pair.cost for pair in result.correspondences], dtype=np.float64),
        "unmatched": np.array(result.unmatched, dtype=np.int64),
    }
    if result.dense is not None:
        arrays["dense_source"] = np.array(result.dense.source, dtype=np.int64)
        arrays["dense_target"] = np.array(result.dense.target, dtype=np.int64)
        arrays["dense_faces"] = _triples(result.dense.faces, np.int64)
        arrays["dense_barycentric"] = _triples(result.dense.barycentric, np.float64)
        if result.dense.inverse is not None:
            inverse = result.dense.inverse
            arrays["inverse_target"] = np.array(inverse.target, dtype=np.int64)
            arrays["inverse_source"] = np.array(inverse.source, dtype=np.int64)
            arrays["inverse_faces"] = _triples(inverse.faces, np.int64)
            arrays["inverse_barycentric"] = _triples(inverse.barycentric, np.float64)
    if result.refinement is not None:
        points = result.refinement.points
        arrays["refined_vertices"] = _triples([one.vertices for one in points], np.int64)
        arrays["refined_weights"] = _triples([one.weights for one in points], np.float64)
    return npz_bytes(arrays)


def _triples(rows: Sequence[tuple[float, ...]], dtype: type[np.generic]) -> NDArray[Any]:
    """(n, 3) array, also of no rows."""
    return np.array(rows, dtype=dtype).reshape(-1, 3)


def summary_of(result: MatchResult) -> MatchSummary:
    """Return a result in brief."""
    return MatchSummary(
        confidence=result.confidence,
        distortion=result.distortion,
        energy=result.energy,
        gap=result.gap,
        certified=result.certified,
        dense=result.dense is not None,
        warnings=result.warnings,
    )


def result_from_blob(packed: bytes) -> MatchResult:
    """Read a stored result."""
    return MatchResult.model_validate_json(gzip.decompress(packed))


def confidence_of(found: Confidence) -> contracts.Confidence:
    """Return the confidence of a match as the contract has it."""
    return contracts.Confidence.model_validate(found, from_attributes=True)


def _relation(best: Correspondence, other: Correspondence, target: TriangleMesh) -> str:
    _, here, there = np.intersect1d(best.source, other.source, return_indices=True)
    answer, alternative = (
        target.vertices[target.vertices_of(found)]
        for found in (best.target[here], other.target[there])
    )
    return relation(answer, alternative).value


def _overlap(found: Overlap) -> contracts.Overlap:
    return contracts.Overlap.model_validate(found, from_attributes=True)


def _proof(found: SampleProof) -> contracts.SampleProof:
    return contracts.SampleProof(
        target_points=found.target_points,
        candidates=found.candidates,
        energy=found.energy,
        lower_bound=found.lower_bound,
        gap=found.gap,
        certified=found.certified,
        correspondences=_pairs(found.optimum),
        distortion=_distortion(found.optimum),
        regions=found.regions,
        seconds=found.seconds,
    )


def _gromov_hausdorff(found: GromovHausdorff | None) -> contracts.GromovHausdorff | None:
    if found is None:
        return None
    return contracts.GromovHausdorff(
        points=found.points,
        value=found.value,
        lower_bound=found.lower_bound,
        gap=found.gap,
        certified=found.certified,
        correspondences=_pairs(found),
        sampling_error=found.sampling_error,
        seconds=found.seconds,
    )


def _dense(found: DenseCorrespondence) -> contracts.DenseCorrespondence:
    return contracts.DenseCorrespondence(
        hypothesis=found.hypothesis,
        source=tuple(found.source.tolist()),
        target=tuple(found.target.tolist()),
        faces=tuple(map(tuple, found.faces.tolist())),
        barycentric=_weight_rows(found.barycentric),
        inverse=None if found.inverse is None else _inverse(found.inverse),
    )


def _inverse(found: DenseCorrespondence) -> contracts.InverseCorrespondence:
    return contracts.InverseCorrespondence(
        target=tuple(found.source.tolist()),
        source=tuple(found.target.tolist()),
        faces=tuple(map(tuple, found.faces.tolist())),
        barycentric=_weight_rows(found.barycentric),
    )


def _weight_rows(weights: FloatArray) -> tuple[tuple[float, ...], ...]:
    return tuple(map(tuple, _rounded(weights).tolist()))


def _rounded(weights: FloatArray) -> FloatArray:
    """(K, 3) barycentric coordinates to four decimals, none negative, of sum 1 as before."""
    rounded = np.clip(weights, 0.0, 1.0).round(_DECIMALS)
    rows = np.arange(len(rounded))
    # The greatest of three is at least a third, so that it stays positive.
    rounded[rows, rounded.argmax(axis=1)] += 1.0 - rounded.sum(axis=1)
    return rounded.round(_DECIMALS)


def _pairs(found: Correspondence | GromovHausdorff) -> tuple[contracts.Correspondence, ...]:
    rows = zip(found.source.tolist(), found.target.tolist(), found.costs.tolist(), strict=True)
    return tuple(
        contracts.Correspondence(source=source, target=target, cost=cost)
        for source, target, cost in rows
    )


def _distortion(found: Correspondence) -> contracts.Distortion:
    return contracts.Distortion.model_validate(found.distortion, from_attributes=True)
