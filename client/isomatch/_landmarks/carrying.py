"""Landmarks of a specimen, merged from those that several templates have."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from isomatch._landmarks.landmark_set import LandmarkSet
from isomatch._landmarks.median import geometric_median
from isomatch._landmarks.surface_points import nearest_points, square_root_of_area
from isomatch._models import TransferredLandmark
from isomatch._results import Geometry
from isomatch._results.summary import screen

Floats = npt.NDArray[np.float64]

NEAR: Final = 0.05
"""Error over √area up to which a landmark counts as right."""


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


def from_transfer(landmarks: Sequence[TransferredLandmark]) -> FromTemplate:
    """Return the landmarks of a transfer; those without a confidence are missing."""

    def column(name: str) -> Floats:
        return np.array([getattr(one, name) for one in landmarks], dtype=np.float64)

    sure = column("confidence")
    positions = np.array([one.position or 3 * (np.nan,) for one in landmarks]).reshape(-1, 3)
    measures = column("round_trip"), column("distortion"), column("from_surface")
    missing = np.isnan(sure)
    for values in (positions, *measures):
        values[missing] = np.nan
    return FromTemplate(positions, sure, *measures)


def missing_landmarks(count: int) -> FromTemplate:
    """Return landmarks that a template lacks."""
    return FromTemplate(np.full((count, 3), np.nan), *(np.full(count, np.nan) for _ in range(4)))


def merged(
    labels: tuple[str, ...],
    each: Sequence[FromTemplate],
    probabilities: Floats,
    specimen: Geometry | None,
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
        Its surface; None if there is one template.
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
    apart = np.zeros(there.shape)
    if specimen is not None:
        positions[several] = nearest_points(specimen, positions[several])
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
        for one, rows in zip(landmarks, same_order(landmarks, names), strict=True)
    ]


def same_order(
    landmarks: Sequence[LandmarkSet], names: Sequence[str] | None = None
) -> list[list[int]]:
    """Return the rows of each template in the order of the first: see :func:`with_same_labels`."""
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
