"""Choice among candidates: all are registered coarsely, the best more finely, and one remains."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.registration.alignment import GLOBAL, LOCAL, Alignment, Pairs, Weights, align
from solver.registration.candidates import Points
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
    Stage(200, 500, (8, 12), GLOBAL, 32),
    Stage(200, 500, (14, 17, 20), GLOBAL, 16),
    Stage(300, 750, (26, 33, 41, 50), LOCAL, 5),
    Stage(750, 1500, (70, 85, 100), LOCAL, 4),
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
    landmarks
        Vertices of X and Y that are known to correspond.
    """

    source: SmoothSurface
    target: SmoothSurface
    samples: tuple[Samples, Samples]
    landmarks: Points

    @property
    def is_reflected(self) -> bool:
        """Whether the source is reflected in space."""
        return self.samples[0].reflection

    def reflected(self) -> "Task":
        """Return the task with the source reflected."""
        return replace(self, samples=(self.samples[0].reflected(), self.samples[1]))

    def missed(self, alignment: Alignment) -> float:
        """Mean distance of the displaced landmarks from where they should be, in √area."""
        here, there = self.landmarks
        if not len(here):
            return 0.0
        functions = self.source.spectrum.eigenfunctions[here, : alignment.size]
        places = functions @ alignment.coefficients
        goals = self.target.mesh.vertices[there]
        return float(np.linalg.norm(places - goals, axis=1).mean())


Start = Callable[[tuple[Samples, Samples]], Iterable[Pairs]]
"""First pairs of candidates, given S and M samples of X and Y."""


def choose(
    task: Task, first: Start, control: Control, stages: Sequence[Stage] = STAGES
) -> list[Candidate]:
    """Register candidates in stages, each of which keeps the best that differ.

    Parameters
    ----------
    task
        The surfaces.
    first
        Where candidates begin.
    control
        May cancel; past its deadline, fewer candidates are tried, at least one in each stage.
    stages
        That candidates go through.

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
    for number, stage in enumerate(stages):
        source = task.samples[0].first(stage.source_samples)
        target = task.samples[1].first(stage.target_samples)
        starts = (
            first((source, target))
            if number == 0
            else (one.alignment.pairs(source, target, stage.weights) for one in kept)
        )
        found = [
            _register(task, source, target, pairs, stage)
            for pairs in control.in_time(starts, least=1)
        ]
        kept = ranked(found, task.target.mesh.vertices)[: stage.kept]
    return kept


def _register(
    task: Task, source: Samples, target: Samples, pairs: Pairs, stage: Stage
) -> Candidate:
    alignment = align(source, target, pairs, stage.sizes, stage.weights)
    fit, found = measure_fit(source, target, alignment, GLOBAL)
    return Candidate(target.vertices[found.images], alignment, fit, task.missed(alignment))


def ranked(found: Sequence[Candidate], positions: FloatArray) -> list[Candidate]:
    """Return candidates that differ, the best first: those that meet landmarks, by their score.

    Parameters
    ----------
    found
        Candidates at the same source samples.
    positions
        (V, 3) vertices of the target.
    """
    least = min((one.missed for one in found), default=0.0)
    order = sorted(found, key=lambda one: (one.missed > least + _LANDMARK, one.fit.score))
    chosen: list[Candidate] = []
    places: list[FloatArray] = []
    for one in order:
        here = positions[one.images]
        if all(float(np.linalg.norm(here - there, axis=1).mean()) > _SAME for there in places):
            chosen.append(one)
            places.append(here)
    return chosen
