"""Partiality: what the two surfaces of a partial registration are to one another.

One is a part of the other, or both only overlap. The search, the comparison and the confidence are
the same for both but for what is described here.
"""

from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from solver.registration.choice import Stage
from solver.registration.confidence import Regression
from solver.registration.partial.alignment import WEIGHTS
from solver.registration.reduction import MANY_VERTICES
from solver.registration.refinement import FEWER_ROUNDS
from solver.registration.surface_map import ROUNDS


@dataclass(frozen=True)
class Labellings:
    """Labellings that are tried.

    Parameters
    ----------
    points
        Points of the part.
    shares
        Areas that the part is taken to have, over that of the whole: scales a quarter apart.
    count
        Labellings of each scale and each cost that are enumerated.
    costs
        Cost of a point without a partner, and weight of the change of curvature.
    best
        How many of the best are tried, however alike.
    apart
        Mean distance of partners over √area of the whole by which the others that are tried differ
        from one another and from the best.
    """

    points: int
    shares: tuple[float, ...]
    count: int
    costs: tuple[tuple[float, float], ...]
    best: int
    apart: float


@dataclass(frozen=True)
class Partiality:
    """What the surfaces are to one another, and what of a registration depends on it.

    Parameters
    ----------
    entire
        Whether every point of the part has a partner. Else the surfaces overlap, and neither is a
        part of the other.
    vertices
        Vertices that both are simplified to while candidates are compared.
    labellings
        Where candidates begin.
    by_distances
        Whether candidates begin by the distances of all samples from the labelled points, too.
    stages
        Of the search.
    rounds
        Of displacement and new images, where a candidate is first refined.
    again, last
        How many of the best are registered again from where they were refined: in each round
        before they are refined twice, and after that.
    mended
        Whether candidates are mended before they are compared at last, or only the answer is.
    in_space
        Whether the answer is refined from a displacement that is smooth in space, too.
    regression
        Of the confidence.
    """

    entire: bool
    vertices: int
    labellings: Labellings
    by_distances: bool
    stages: tuple[Stage, ...]
    rounds: int
    again: tuple[int, ...]
    last: int
    mended: bool
    in_space: bool
    regression: Regression


FINEST = Stage(750, 800, (60, 70, 85), 8, WEIGHTS)
"""Last stage of surfaces that overlap; its samples are those that parts are refined from, too."""

SAME_OVERLAP = 0.1
"""As `SAME`, of surfaces that overlap; the stages of `OF_OVERLAP` say what it changes."""

OF_PART = Partiality(
    entire=True,
    # With 1,500, more answers are wrong, and with 10,000 none fewer, in half as much time again.
    vertices=2_500,
    # With fourteen points, more answers are wrong. Of 14 hard halves of bodies, four are wrong with
    # a weight of 0.02 of the curvature, one with 0.1.
    labellings=Labellings(8, (0.35, 0.55, 0.85), 1000, ((np.inf, 0.0), (np.inf, 0.1)), 50, 0.1),
    by_distances=True,
    # What fits best here is often wrong, so that as many are kept as can be refined: of seven
    # halves of bodies that had wrong answers, a right candidate was the first to 34th that differs
    # from those before it.
    stages=(
        Stage(200, 400, (8, 10, 12, 14, 17, 20), 40, WEIGHTS),
        Stage(300, 600, (26, 33, 41, 50), 40, WEIGHTS),
    ),
    # They are refined again.
    rounds=FEWER_ROUNDS,
    # Of 14 hard halves of bodies, seven were wrong without it, and two with it, or with 12 and 6.
    again=(8, 4),
    # A choice, as many as in the round before.
    last=4,
    mended=True,
    in_space=True,
    # Fitted to 196 generated people, of which 186 are right, corrected to five right ones for each
    # wrong one, as users' parts may be harder: the mean of those of `python -m bench.partial --fit`
    # for `--first 300 --count 96` and `--first 500 --count 100`, whose intercepts are for as many
    # wrong ones as right ones, plus log 5.
    regression=Regression(MappingProxyType({"score": -0.50, "margin": 4.3}), -8.0),
)
"""One surface is a part of the other: every point of it has a partner."""

OF_OVERLAP = Partiality(
    entire=False,
    vertices=MANY_VERTICES,
    # Distances between few points that happen to fit say little, so that the curvature is asked as
    # well. With half as many labellings, two of 34 generated pairs more have no right one. With the
    # 50 best of each and those of 1,000 that differ by 0.1, one of 11 scanned pairs more is wrong,
    # none more right.
    labellings=Labellings(
        12, (0.65, 1.0, 1.5), 300, ((0.025, 0.0), (0.0125, 0.015), (0.025, 0.03)), 300, 0.0
    ),
    by_distances=False,
    # Fewer labellings are right, so that there are more candidates, and more that differ are kept:
    # with 20 eigenfunctions, right ones of generated pairs are often behind 60 to 100 wrong ones,
    # which cover more. Of 10 hard pairs, a candidate that is right where it covers is kept for 10,
    # and for 4 with 16 candidates at the end and `same` 0.05; it is not always chosen.
    stages=(
        Stage(100, 200, (8, 10, 12), 200, WEIGHTS, same=SAME_OVERLAP),
        Stage(200, 400, (14, 17, 20), 100, WEIGHTS, same=SAME_OVERLAP),
        Stage(300, 600, (26, 33, 41, 50), 50, WEIGHTS, same=SAME_OVERLAP),
        replace(FINEST, kept=24, same=SAME_OVERLAP),
    ),
    rounds=ROUNDS,
    again=(),
    last=0,
    # Of 59 pairs, 13 were wrong when candidates were mended, else 12.
    mended=False,
    # It would draw what has no partner.
    in_space=False,
    # As for parts, corrected to seven right ones for each three wrong ones: of `--both --count 22`,
    # and of 18 of `--both --opposite --detected` as matched before; 32 of these 40 generated pairs
    # are right. Wrong answers fit as well as right ones, so that only the margin tells: without
    # any, an answer is doubtful.
    regression=Regression(MappingProxyType({"margin": 5.3}), -0.86),
)
"""Both surfaces overlap: neither is a part of the other."""
