"""Landmarks of templates carried to a specimen along dense matches, computed locally."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from isomatch._landmarks.confidence import (
    NEAR,
    confidence,
    local_distortion,
    square_root_of_area,
)
from isomatch._landmarks.landmark_set import LandmarkSet
from isomatch._landmarks.median import geometric_median
from isomatch._landmarks.placing import PlacedLandmarks
from isomatch._landmarks.remarks import FAR
from isomatch._landmarks.surface_points import images, nearest_points
from isomatch._models import VertexMap
from isomatch._results import Geometry, Match
from isomatch._results.summary import screen

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class CarriedLandmarks:
    """Landmarks of a specimen, carried from one or several templates.

    Lengths but `positions` are over the square root of a surface's area. Rows of landmarks that are
    missing on all templates are nan: they were missing there, are farther than 0.05 from its
    surface, or lie on what a part lacks.

    Attributes
    ----------
    labels
        Name of each landmark, n of them, in the order of the first template.
    positions
        On the specimen's surface, in the coordinates of its file, (n, 3) float64. From several
        templates, the point nearest to the geometric median of their positions, weighted by their
        confidence.
    confidence
        Probability that each is within 0.05 of the right place, (n,) float64.
    round_trip
        Distance on the template between each landmark and the image of its image, (n,) float64;
        the mean over the templates.
    distortion
        Deviation of the map from a rigid motion within 0.1 of the landmark, (n,) float64; the mean
        over the templates.
    spread
        Mean distance of the templates' positions from that of the result, (n,) float64; nan where
        fewer than two templates have the landmark.
    from_surface
        Distance of the landmark from the surface of its template, (n,) float64; the greatest of the
        templates.
    probabilities
        Confidence of the match of each template, (T,) float64.
    """

    labels: tuple[str, ...]
    positions: Floats
    confidence: Floats
    round_trip: Floats
    distortion: Floats
    spread: Floats
    from_surface: Floats
    probabilities: Floats

    def __repr__(self) -> str:
        found = np.count_nonzero(~np.isnan(self.confidence))
        return f"<CarriedLandmarks of {found} of {len(self.labels)} landmarks>"

    def __str__(self) -> str:
        found = np.count_nonzero(~np.isnan(self.confidence))
        lines = [
            f"{label}: {'missing' if np.isnan(one) else f'confidence {one:.2f}'}"
            for label, one in zip(self.labels, self.confidence, strict=True)
        ]
        return screen(f"{found} of {len(self.labels)} landmarks carried", lines)

    def landmark_set(self, name: str = "") -> LandmarkSet:
        """Return the landmarks for a file, each with its confidence as description.

        Parameters
        ----------
        name
            Name of the specimen.
        """
        said = tuple("" if np.isnan(one) else f"confidence {one:.2f}" for one in self.confidence)
        return LandmarkSet(self.labels, self.positions, name, said)


@dataclass(frozen=True, eq=False)
class FromTemplate:
    """Landmarks of a specimen from one template: see :class:`CarriedLandmarks`."""

    positions: Floats
    confidence: Floats
    round_trip: Floats
    distortion: Floats
    from_surface: Floats

    def at(self, rows: list[int]) -> "FromTemplate":
        """Return the landmarks of some rows."""
        return FromTemplate(*(values[rows] for values in vars(self).values()))


def carried_landmarks(
    templates: Sequence[PlacedLandmarks], matches: Sequence[Match], specimen: Geometry
) -> CarriedLandmarks:
    """Carry landmarks of templates to a specimen.

    Parameters
    ----------
    templates
        Landmarks of each template, with the same labels.
    matches
        Of each template with the specimen, dense and with a confidence.
    specimen
        Its surface.

    Raises
    ------
    ValueError
        Labels differ, or a match has no dense map in both directions or no confidence.
    """
    each = []
    orders = _same_order([one.landmarks for one in templates])
    probabilities = []
    for template, order, match in zip(templates, orders, matches, strict=True):
        if match.dense is None or match.confidence is None:
            raise ValueError("landmarks are carried along dense matches with a confidence")
        probabilities.append(match.confidence.probability)
        each.append(
            from_template(
                template,
                (match.dense.source_to_target, match.dense.target_to_source),
                match.confidence.probability,
                specimen,
                None if match.overlap is None else match.overlap.scale,
            ).at(order)
        )
    return merged(templates[0].landmarks.labels, each, np.array(probabilities), specimen)


def from_template(
    template: PlacedLandmarks,
    maps: tuple[VertexMap, VertexMap],
    probability: float,
    specimen: Geometry,
    scale: float | None = None,
) -> FromTemplate:
    """Carry the landmarks of one template.

    Landmarks are missing that are farther than `FAR` from the template, and those of a part whose
    triangle, or that of whose image, has a corner without a partner.

    Parameters
    ----------
    template
        Its landmarks, on its surface.
    maps
        From the template to the specimen, and from the specimen to the template.
    probability
        Confidence of the match.
    specimen
        Its surface.
    scale
        As for :func:`.local_distortion`.
    """
    there, back = maps
    landmarks, surface, nearest = template.landmarks, template.surface, template.nearest
    carried = np.flatnonzero(nearest.among(there.vertices) & (template.apart <= FAR))
    found = images(nearest.at(carried), there, specimen)
    returning = found.among(back.vertices)
    carried, found = carried[returning], found.at(returning)
    here = nearest.at(carried).positions(surface)
    returned = images(found, back, surface).positions(surface)
    trips = np.linalg.norm(returned - here, axis=1) / template.size
    part = _part_of(surface, there.vertices)
    changes = local_distortion(part, there, specimen, here, scale)

    def placed(values: Floats) -> Floats:
        every = np.full((len(landmarks), *values.shape[1:]), np.nan)
        every[np.flatnonzero(landmarks.present)[carried]] = values
        return every

    return FromTemplate(
        positions=placed(found.positions(specimen)),
        confidence=placed(confidence(probability, trips, changes)),
        round_trip=placed(trips),
        distortion=placed(changes),
        from_surface=placed(template.apart[carried]),
    )


def merged(
    labels: tuple[str, ...], each: Sequence[FromTemplate], probabilities: Floats, specimen: Geometry
) -> CarriedLandmarks:
    """Merge what several templates say of one specimen.

    The confidence is the mean of the templates' confidences, weighted by themselves, where a
    template whose position is more than `NEAR` from the result counts as 0.

    Parameters
    ----------
    labels
        Of the landmarks.
    each
        What each template says.
    probabilities
        Confidence of the match of each.
    specimen
        Its surface.
    """
    places = np.stack([one.positions for one in each], axis=1)
    sure = np.stack([one.confidence for one in each], axis=1)
    there = ~np.isnan(sure)
    weights = np.where(there, sure, 0.0)
    positions = np.full((len(labels), 3), np.nan)
    some = there.any(axis=1)
    for row in np.flatnonzero(some):
        chosen = there[row]
        positions[row] = geometric_median(places[row, chosen], sure[row, chosen])
    several = there.sum(axis=1) > 1
    positions[several] = nearest_points(specimen, positions[several]).positions(specimen)
    apart = np.linalg.norm(places - positions[:, None], axis=2) / square_root_of_area(specimen)
    total = np.where(some, np.maximum(weights.sum(axis=1), np.finfo(float).tiny), np.nan)
    agreed = np.where(there & (apart <= NEAR), weights**2, 0.0).sum(axis=1)

    def mean(values: Floats) -> Floats:
        sums = np.where(there, values, 0.0).sum(axis=1)
        found: Floats = np.where(some, sums / np.maximum(there.sum(axis=1), 1), np.nan)
        return found

    surface = np.stack([one.from_surface for one in each], axis=1)
    return CarriedLandmarks(
        labels=labels,
        positions=positions,
        confidence=agreed / total,
        round_trip=mean(np.stack([one.round_trip for one in each], axis=1)),
        distortion=mean(np.stack([one.distortion for one in each], axis=1)),
        spread=np.where(several, mean(apart), np.nan),
        from_surface=np.where(some, np.where(there, surface, 0.0).max(axis=1), np.nan),
        probabilities=probabilities,
    )


def with_same_labels(
    landmarks: Sequence[LandmarkSet], names: Sequence[str] | None = None
) -> list[LandmarkSet]:
    """Return landmarks of templates in the order of the first.

    Parameters
    ----------
    landmarks
        Of each template.
    names
        What errors call each; "template 1", ... by default.

    Raises
    ------
    ValueError
        Their labels differ, or some occur twice and the order differs.
    """
    first = landmarks[0].labels
    return [
        one if one.labels == first else LandmarkSet(first, one.positions[rows], one.name)
        for one, rows in zip(landmarks, _same_order(landmarks, names), strict=True)
    ]


def _same_order(
    landmarks: Sequence[LandmarkSet], names: Sequence[str] | None = None
) -> list[list[int]]:
    """Rows of each template in the order of the first: see :func:`with_same_labels`."""
    named = names or [f"template {number + 1}" for number in range(len(landmarks))]
    first = landmarks[0].labels
    orders = []
    for one, name in zip(landmarks, named, strict=True):
        if one.labels == first:
            orders.append(list(range(len(first))))
            continue
        if Counter(one.labels) != Counter(first):
            raise ValueError(_differing(first, one.labels, (named[0], name)))
        if len(set(first)) < len(first):
            raise ValueError(
                f"{named[0]} and {name} have landmarks of the same label in different orders;"
                " rename them"
            )
        orders.append([one.labels.index(label) for label in first])
    return orders


def _differing(first: Sequence[str], other: Sequence[str], names: tuple[str, str]) -> str:
    """Say which landmark one template has and the other lacks."""
    here, there = Counter(first) - Counter(other), Counter(other) - Counter(first)
    (label, _), *rest = (here or there).items()
    having, lacking = names if here else names[::-1]
    more = f" and {len(rest)} more" if rest else ""
    return (
        f"{names[0]} and {names[1]} do not have the same landmarks: {having} has {label!r}{more},"
        f" {lacking} does not"
    )


def _part_of(geometry: Geometry, vertices: npt.NDArray[np.int64]) -> Geometry:
    """The surface without faces that are not mapped, such as other components."""
    kept = np.isin(geometry.vertex_ids[geometry.faces], vertices).all(axis=1)
    if not kept.any():
        raise ValueError("the match has no map of the template's surface; do not simplify it")
    return Geometry(geometry.vertices, geometry.faces[kept], geometry.vertex_ids, None)
