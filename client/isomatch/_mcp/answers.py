"""Answers of the tools: short, and structured; arrays are in files."""

from itertools import zip_longest
from typing import Final

import numpy as np
from pydantic import BaseModel, Field

from isomatch._models import Confidence, Shape, SurfacePoint
from isomatch._results import Dissimilarities, Match, Transfer

MOST_SHAPES: Final = 12
"""Shapes whose dissimilarities are given pair by pair."""

MOST_LINES: Final = 50
"""Entries of a list."""

NEAREST: Final = 3
"""Nearest shapes of each."""


class UploadAnswer(BaseModel):
    """An uploaded shape."""

    id: str = Field(description="Names the shape in other tools; the same file has the same id.")
    name: str
    kind: str
    vertices: int
    faces: int
    components: int
    closed: bool
    area: float
    warnings: tuple[str, ...] = Field(description="What was repaired, left out or linked.")


class Certificate(BaseModel):
    """What is proven of an energy."""

    certified: bool
    lower_bound: float
    gap: float
    scope: str = Field(description="What the proof is about, and what it does not say.")


class Trust(BaseModel):
    """How probable it is that the answer is right."""

    probability: float
    in_doubt: bool
    reasons: tuple[str, ...]


class Other(BaseModel):
    """Another good correspondence."""

    number: int = Field(description="`alternative` of the tool `picture`.")
    relation: str | None
    energy: float


class MatchAnswer(BaseModel):
    """A match, without its pairs, which are in the file."""

    job: str = Field(description="Names the match in `transfer` and `picture`.")
    source: str
    target: str
    points: int = Field(description="Number of matched pairs.")
    dense: bool = Field(description="Whether all vertices are mapped, as `transfer` needs.")
    energy: float
    certificate: Certificate
    confidence: Trust | None = Field(
        description="None where the surfaces were not registered: nothing is known."
    )
    gromov_hausdorff_bound: float
    overlap: str | None = Field(description="Where one shape is a part of the other, or both are.")
    unmatched: int = Field(description="Points left without a partner.")
    alternatives: tuple[Other, ...]
    warnings: tuple[str, ...]
    seconds: float
    file: str | None = Field(description="File of the result, if `save_to` was given.")


class Compared(BaseModel):
    """A shape of a comparison with its nearest others."""

    id: str
    name: str
    nearest: tuple[str, ...] = Field(description="Names of the nearest shapes, nearest first.")
    dissimilarities: tuple[float, ...] = Field(description="To these, in the same order.")


class CompareAnswer(BaseModel):
    """Dissimilarities of several shapes."""

    job: str
    shapes: tuple[Compared, ...]
    shapes_not_listed: int
    matrix: tuple[tuple[float, ...], ...] | None = Field(
        description=f"Of at most {MOST_SHAPES} shapes, in their order; of more it is in the file."
    )
    certified: bool = Field(description="Whether every dissimilarity is proven to be least.")
    uncertified_pairs: int
    warnings: tuple[str, ...]
    file: str | None


class CarriedPoint(BaseModel):
    """Image of a landmark."""

    vertex: int = Field(description="Corner of greatest weight of the triangle on the target.")
    position: tuple[float, ...] | None
    confidence: float | None = Field(description="Probability that the image is about right.")


class TransferAnswer(BaseModel):
    """What was carried; values are in the file."""

    job: str
    what: str
    source: str
    target: str
    attributes: tuple[str, ...]
    attributes_not_listed: int
    on: str
    rows: int = Field(description="Number of values of each attribute, or of landmarks.")
    points: tuple[CarriedPoint | None, ...] | None = Field(
        description=f"Images of landmarks on the target, at most {MOST_LINES}, None where one has"
        " no partner; None for values."
    )
    points_not_listed: int = Field(description="They are in the file, if `save_to` was given.")
    confidence: Trust | None = Field(
        description="That the match is right; None where nothing is known."
    )
    warnings: tuple[str, ...]
    file: str | None


def upload_answer(shape: Shape) -> UploadAnswer:
    """Return what a model needs of a shape."""
    fields = UploadAnswer.model_fields
    return UploadAnswer.model_validate(shape.model_dump(include=set(fields)))


def match_answer(job: str, match: Match, file: str | None) -> MatchAnswer:
    """Return a match with its certificate and confidence, and without its arrays."""
    return MatchAnswer(
        job=job,
        source=_named(match.source_name, match.source),
        target=_named(match.target_name, match.target),
        points=len(match.correspondences),
        dense=match.dense is not None,
        energy=match.energy,
        certificate=_certificate(match),
        confidence=_trust(match.confidence),
        gromov_hausdorff_bound=match.gromov_hausdorff,
        overlap=None if match.overlap is None else str(match.overlap),
        unmatched=len(match.unmatched),
        alternatives=tuple(
            Other(number=number, relation=other.relation, energy=other.energy)
            for number, other in enumerate(match.alternatives, 1)
        ),
        warnings=match.warnings,
        seconds=match.timings.get("total", 0.0),
        file=file,
    )


def _trust(sure: Confidence | None) -> Trust | None:
    if sure is None:
        return None
    return Trust(probability=sure.probability, in_doubt=sure.in_doubt, reasons=sure.reasons)


def _certificate(match: Match) -> Certificate:
    """Return the certificate of the match's own energy, with the proof over samples in words."""
    scope = (
        "correspondences among the candidates of the finest level; it says nothing of other"
        " points, and not that the answer is right"
    )
    if match.proof is not None:
        state = "is the least" if match.proof.certified else "is the least known"
        scope += (
            f". Over all samples {match.proof.energy:.6g} {state} energy, and the lower bound"
            f" {match.proof.lower_bound:.6g}"
        )
    return Certificate(
        certified=match.certified, lower_bound=match.lower_bound, gap=match.gap, scope=scope
    )


def compare_answer(job: str, found: Dissimilarities, file: str | None) -> CompareAnswer:
    """Return the nearest shapes of each, and the matrix of a few."""
    names = found.names or found.shapes
    count = len(found.shapes)
    listed = [
        Compared(
            id=shape,
            name=names[number],
            nearest=tuple(names[other] for other in found.nearest[number][:NEAREST]),
            dissimilarities=tuple(
                _rounded(found.matrix[number, other]) for other in found.nearest[number][:NEAREST]
            ),
        )
        for number, shape in enumerate(found.shapes[:MOST_LINES])
    ]
    matrix = tuple(tuple(map(_rounded, row)) for row in np.asarray(found.matrix))
    return CompareAnswer(
        job=job,
        shapes=tuple(listed),
        shapes_not_listed=count - len(listed),
        matrix=matrix if count <= MOST_SHAPES else None,
        certified=found.certified,
        uncertified_pairs=len(found.uncertified),
        warnings=found.warnings,
        file=file,
    )


def transfer_answer(job: str, found: Transfer, file: str | None) -> TransferAnswer:
    """Return what was carried, and the images of a few landmarks."""
    points = found.points or ()
    return TransferAnswer(
        job=job,
        what=found.what,
        source=_named(found.source_name, found.source),
        target=_named(found.target_name, found.target),
        attributes=tuple(one.name for one in found.attributes[:MOST_LINES]),
        attributes_not_listed=max(0, len(found.attributes) - MOST_LINES),
        on=found.on,
        rows=found.rows if found.points is None else len(points),
        points=None if found.points is None else _carried(found),
        points_not_listed=max(0, len(points) - MOST_LINES),
        confidence=_trust(found.confidence),
        warnings=found.warnings,
        file=file,
    )


def _carried(found: Transfer) -> tuple[CarriedPoint | None, ...]:
    """Return the first landmarks; results of earlier versions have no confidences of them."""
    sure = [one.confidence for one in found.landmarks or ()]
    listed = zip_longest((found.points or ())[:MOST_LINES], sure[:MOST_LINES])
    return tuple(None if point is None else _carried_point(point, own) for point, own in listed)


def _carried_point(point: SurfacePoint, sure: float | None) -> CarriedPoint:
    return CarriedPoint(
        vertex=max(zip(point.weights, point.vertices, strict=True))[1],
        position=None if point.position is None else tuple(map(_rounded, point.position)),
        confidence=None if sure is None else round(sure, 2),
    )


def _rounded(number: float) -> float:
    return float(f"{number:.6g}")


def _named(name: str | None, shape: str) -> str:
    return shape if name is None else f"{name} ({shape})"
