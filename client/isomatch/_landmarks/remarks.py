"""Landmarks that do not lie on the surface of their template: remarks on them, and refusals.

The service has the same remarks on what it carries; these are made before anything is matched.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from isomatch._errors import WrongCoordinates
from isomatch._landmarks.landmark_set import LandmarkSet
from isomatch._landmarks.surface_points import nearest_points, square_root_of_area
from isomatch._results import Geometry

Floats = npt.NDArray[np.float64]

FAR: Final = 0.05
"""Distance from the surface, over √area, above which a landmark is reported and not carried."""

_BESIDE: Final = 0.01
"""Median distance, over √area, up to which landmarks are taken to be placed on the surface."""

_MOST_NAMED: Final = 5


def remarks_on(landmarks: LandmarkSet, template: Geometry) -> tuple[str, ...]:
    """Report landmarks that are far from the surface of their template, and labels that recur.

    Parameters
    ----------
    landmarks
        Of the template.
    template
        Its surface.

    Returns
    -------
    Sentences; none if the landmarks lie on the surface and each has a label of its own.

    Raises
    ------
    WrongCoordinates
        With x and y negated fewer than half as many are far from the surface, and the median
        distance is less than half: in the wrong system some are near it by chance.
    ValueError
        All landmarks are missing or far, so that none can be carried.
    """
    if not landmarks.present.any():
        raise ValueError("all landmarks are missing")
    found = _Distances.of(landmarks, template)
    found.refuse_wrong_coordinates()
    remarks = _recurring(landmarks.labels)
    hint = ""
    if np.median(found.apart) > _BESIDE and found.nearer_if_negated:
        hint = "with x and y negated they are nearer: check the coordinate system (LPS or RAS)"
    if found.far.all():
        hint = hint or "check the unit of length and the coordinate system (LPS or RAS)"
        raise ValueError(f"{found}: {hint}")
    if found.far.any():
        they = "it is" if found.far.sum() == 1 else "they are"
        remarks.append(f"{found}; {they} left out" + (hint and f"; {hint}"))
    elif hint:
        remarks.append(f"the landmarks lie beside the surface; {hint}")
    return tuple(remarks)


def _recurring(labels: Sequence[str]) -> list[str]:
    """A sentence for each label of several landmarks."""
    counts = Counter(labels)
    return [
        f"{count} landmarks are called {label!r}; only their order tells them apart"
        for label, count in counts.items()
        if count > 1
    ]


@dataclass(frozen=True, eq=False)
class _Distances:
    """Distances of landmarks from a surface.

    Attributes
    ----------
    labels
        Of the landmarks that are not missing, n of them.
    apart, negated
        Their distances over √area, as given and with x and y negated, (n,).
    size
        Square root of the area.
    """

    labels: tuple[str, ...]
    apart: Floats
    negated: Floats
    size: float

    @classmethod
    def of(cls, landmarks: LandmarkSet, template: Geometry) -> "_Distances":
        """Measure the distances of landmarks, of which some are present."""
        size = square_root_of_area(template)
        rows = np.flatnonzero(landmarks.present)
        labels = tuple(landmarks.labels[row] for row in rows)
        apart = _distances(template, landmarks.positions[rows]) / size
        negated = apart
        if apart.max() > _BESIDE:
            negated = _distances(template, landmarks.flipped().positions[rows]) / size
        return cls(labels, apart, negated, size)

    @property
    def far(self) -> npt.NDArray[np.bool_]:
        """Whether each landmark is far from the surface, (n,)."""
        return self.apart > FAR

    @property
    def nearer_if_negated(self) -> bool:
        """Whether negating x and y halves the median distance."""
        return bool(np.median(self.negated) < 0.5 * np.median(self.apart))

    def refuse_wrong_coordinates(self) -> None:
        """Raise :class:`WrongCoordinates` if negating x and y brings the landmarks home."""
        count = int((self.negated > FAR).sum())
        if 2 * count < self.far.sum() and self.nearer_if_negated:
            raise WrongCoordinates(
                f"{self}, but {count or 'none'} with x and y negated: the landmarks are not in the"
                " coordinate system of the mesh (LPS or RAS)"
            )

    def __str__(self) -> str:
        worst = np.flatnonzero(self.far)
        worst = worst[np.argsort(-self.apart[worst], kind="stable")]
        named = [
            f"{self.labels[row]!r} by {self.apart[row] * self.size:.4g}"
            for row in worst[:_MOST_NAMED]
        ]
        if len(worst) > _MOST_NAMED:
            named.append(f"and {len(worst) - _MOST_NAMED} more")
        be = "is" if len(worst) == 1 else "are"
        return f"{len(worst)} of {len(self.apart)} landmarks {be} far from the surface, " + (
            ", ".join(named)
        )


def _distances(geometry: Geometry, positions: Floats) -> Floats:
    found: Floats = np.linalg.norm(positions - nearest_points(geometry, positions), axis=1)
    return found
