"""Choice among candidates: all are registered coarsely, the best more finely, and one remains."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.registration.alignment import GLOBAL, LOCAL, Alignment, Pairs, Weights, align
from solver.registration.candidates import Points, first_pairs
from solver.registration.fit import Fit, measure_fit
from solver.registration.surface import Samples, SmoothSurface


@dataclass(frozen=True)
class Stage:
    """One stage of the choice.

    Parameters
    ----------
    source_samples, target_samples
        Numbers of samples.
    sizes
        Numbers of eigenfunctions, each some 1.2 times the one before.
    weights
        Of the embedding in which neighbours are found.
    kept
        Greatest number of candidates that are kept.
    """

    source_samples: int
    target_samples: int
    sizes: tuple[int, ...]
    weights: Weights
    kept: int


# Chosen on generated people and animals: `python -m bench.dense`.
STAGES = (
    Stage(200, 500, (12, 14, 17, 20), GLOBAL, 20),
    Stage(300, 750, (26, 33, 41, 50), LOCAL, 6),
    Stage(750, 1500, (60, 75, 90, 100), LOCAL, 6),
)

_SAME = 0.05
"""Mean distance in space over √area between the images of candidates that are the same."""

_LANDMARK = 0.1
"""Mean distance in space over √area within which landmarks are met as well as they can be."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """A registered candidate.

    Parameters
    ----------
    images
        (S,) target vertices of the source samples of the last stage.
    alignment
        Its alignment.
    fit
        Its fit.
    missed
        Mean distance of the displaced landmarks from where they should be, in √area; 0 without
        landmarks.
    """

    images: IntArray
    alignment: Alignment
    fit: Fit
    missed: float = 0.0


@dataclass(frozen=True, eq=False)
class Task:
    """Two surfaces to be registered.

    Parameters
    ----------
    source, target
        The surfaces X and Y.
    samples
        Samples of both; the source may be reflected.
    hypotheses
        Corresponding vertices of X and Y, each a candidate.
    signs
        Whether the signs of eigenfunctions are candidates as well.
    landmarks
        Vertices of X and Y that are known to correspond.
    """

    source: SmoothSurface
    target: SmoothSurface
    samples: tuple[Samples, Samples]
    hypotheses: Sequence[Points]
    signs: bool
    landmarks: Points

    def missed(self, alignment: Alignment) -> float:
        """Mean distance of the displaced landmarks from where they should be, in √area."""
        here, there = self.landmarks
        if not len(here):
            return 0.0
        functions = self.source.spectrum.eigenfunctions[here, : alignment.size]
        places = functions @ alignment.coefficients
        goals = self.target.mesh.vertices[there]
        return float(np.linalg.norm(places - goals, axis=1).mean())


def choose(task: Task, control: Control) -> list[Candidate]:
    """Register candidates in stages, each of which keeps the best that differ.

    Parameters
    ----------
    task
        Surfaces, and where to begin.
    control
        May cancel; past its deadline, fewer candidates are tried, at least one in each stage.

    Returns
    -------
    Candidates of the last stage, the best first: those that meet the landmarks, by their score.
    Empty if there is nothing to begin with.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    kept: list[Candidate] = []
    for number, stage in enumerate(STAGES):
        source = task.samples[0].first(stage.source_samples)
        target = task.samples[1].first(stage.target_samples)
        starts = (
            first_pairs((task.source, task.target), (source, target), task.hypotheses, task.signs)
            if number == 0
            else (one.alignment.pairs(source, target, stage.weights) for one in kept)
        )
        found = [
            _register(task, source, target, pairs, stage)
            for pairs in control.in_time(starts, least=1)
        ]
        kept = drop_similar(_ranked(found), task.target.mesh.vertices)[: stage.kept]
    return kept


def _register(
    task: Task, source: Samples, target: Samples, pairs: Pairs, stage: Stage
) -> Candidate:
    alignment = align(source, target, pairs, stage.sizes, stage.weights)
    fit, found = measure_fit(source, target, alignment, GLOBAL)
    return Candidate(target.vertices[found.images], alignment, fit, task.missed(alignment))


def _ranked(found: Sequence[Candidate]) -> list[Candidate]:
    least = min((one.missed for one in found), default=0.0)
    return sorted(found, key=lambda one: (one.missed > least + _LANDMARK, one.fit.score))


def drop_similar(ranked: Sequence[Candidate], positions: FloatArray) -> list[Candidate]:
    """Leave out candidates whose images are those of an earlier one.

    Parameters
    ----------
    ranked
        Candidates at the same source samples.
    positions
        (V, 3) vertices of the target.
    """
    chosen: list[Candidate] = []
    places: list[FloatArray] = []
    for one in ranked:
        here = positions[one.images]
        if all(float(np.linalg.norm(here - there, axis=1).mean()) > _SAME for there in places):
            chosen.append(one)
            places.append(here)
    return chosen
