"""Choice among candidates: all are registered coarsely, the best more finely, and one remains."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import compress
from typing import ClassVar, Protocol, TypeVar

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.functional_maps import nearest_points
from solver.registration.alignment import GLOBAL, LOCAL, Alignment, Pairs, Weights, align
from solver.registration.candidates import NO_LANDMARKS, Points, first_pairs
from solver.registration.fit import UNMEASURED, Fit, LocalFit, measure_fit
from solver.registration.surface import MIRROR, Samples, SmoothSurface, smooth_surface
from solver.shape import Shape

SAME = 0.05
"""Mean distance in space over √area between the images of candidates that are the same. A choice,
half of the error of a right answer; of surfaces that overlap, it is `SAME_OVERLAP`."""


@dataclass(frozen=True)
class Stage:
    """One stage of the choice.

    Parameters
    ----------
    source_samples, target_samples
        Numbers of samples.
    sizes
        Numbers of eigenfunctions, each some 1.2 times the one before.
    kept
        Greatest number of candidates that are kept.
    weights
        Of the embedding in which neighbours are found.
    same
        Mean distance in space over √area between the images of candidates that are the same.
    distances
        Whether the change of distances is measured, which only tells how probable an answer is.
    """

    source_samples: int
    target_samples: int
    sizes: tuple[int, ...]
    kept: int
    weights: Weights = GLOBAL
    same: float = SAME
    distances: bool = False


# Chosen on generated people and animals: `python -m bench.dense`.
COARSE = (
    Stage(200, 500, (8, 12), 32),
    Stage(200, 500, (14, 17, 20), 32),
)
FINE = (
    Stage(300, 750, (26, 33, 41, 50), 5, LOCAL),
    Stage(750, 1500, (70, 85, 100), 6, LOCAL, distances=True),
)

LANDMARK_TOLERANCE = 0.1
"""Mean distance in space over √area by which candidates may miss landmarks more than the one that
misses them least: they meet them as well. A choice, as great as the error of a right answer."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """A registered candidate.

    Parameters
    ----------
    alignment
        Its alignment.
    fit
        How well it fits.
    images
        (S,) vertices that candidates are compared by: those of the target that the source samples
        of the last stage go to; of a part, those of the whole that its first samples go to.
    local
        What the local measures are made of; nothing of a part.
    missed
        Mean distance of the displaced landmarks from where they should be, in √area of the source;
        0 without landmarks.
    scale
        √area of the source in the target's unit.
    """

    alignment: Alignment
    fit: Fit
    images: IntArray
    local: LocalFit = UNMEASURED
    missed: float = 0.0
    scale: float = 1.0


SamplesT = TypeVar("SamplesT")
"""Samples of two surfaces."""

StartT = TypeVar("StartT")
"""Where a candidate begins."""


class Registering(Protocol[SamplesT, StartT]):
    """Two surfaces, and how candidates of them are registered."""

    @property
    def positions(self) -> FloatArray:
        """(V, 3) vertices that images of candidates are among, at √area 1."""

    @property
    def drops_missing(self) -> bool:
        """Whether candidates that miss landmarks are dropped in each stage; else they come last."""

    def sampled(self, stage: Stage) -> SamplesT:
        """Samples of a stage."""

    def again(
        self, candidates: Iterable[Candidate], stage: Stage
    ) -> Callable[[SamplesT], Iterable[StartT]]:
        """Where candidates go on in a further stage."""

    def register(self, samples: SamplesT, start: StartT, stage: Stage) -> Candidate:
        """Register a candidate in one stage, whose samples are given, and measure its fit."""


@dataclass(frozen=True, eq=False)
class Task:
    """Two surfaces to be registered.

    Parameters
    ----------
    source, target
        The surfaces X and Y.
    samples
        Samples of both, of which one may be reflected.
    landmarks
        Vertices of X and Y that are known to correspond.
    """

    source: SmoothSurface
    target: SmoothSurface
    samples: tuple[Samples, Samples]
    landmarks: Points

    drops_missing: ClassVar[bool] = False

    @classmethod
    def of(cls, source: Shape, target: Shape, landmarks: Points = NO_LANDMARKS) -> "Task":
        """Return the task of two shapes.

        Parameters
        ----------
        source, target
            The shapes X and Y.
        landmarks
            Vertices of X and Y that are known to correspond.
        """
        return cls.of_surfaces(smooth_surface(source), smooth_surface(target), landmarks)

    @classmethod
    def of_surfaces(
        cls, source: SmoothSurface, target: SmoothSurface, landmarks: Points = NO_LANDMARKS
    ) -> "Task":
        """Return the task of two surfaces, of which none is reflected."""
        return cls(source, target, (source.samples, target.samples), landmarks)

    @property
    def is_reflected(self) -> bool:
        """Whether the source is reflected in space."""
        return self.samples[0].reflection

    @cached_property
    def positions(self) -> FloatArray:
        """(V, 3) vertices of the target, at √area 1, reflected if its samples are."""
        vertices = self.target.mesh.vertices
        return vertices * MIRROR if self.samples[1].reflection else vertices

    def reflected(self) -> "Task":
        """Return the task with the source reflected."""
        return replace(self, samples=(self.samples[0].reflected(), self.samples[1]))

    def swapped(self) -> "Task":
        """Return the task with source and target exchanged."""
        return Task(self.target, self.source, self.samples[::-1], self.landmarks[::-1])

    def sampled(self, stage: Stage) -> tuple[Samples, Samples]:
        """Samples of a stage."""
        source, target = self.samples
        return source.first(stage.source_samples), target.first(stage.target_samples)

    def missed(self, alignment: Alignment) -> float:
        """Mean distance of the displaced landmarks from where they should be, in √area."""
        return missed(self.source, self.positions, alignment, self.landmarks)

    def again(self, candidates: Iterable[Candidate], stage: Stage) -> "FirstPairs":
        """Return where candidates go on in a further stage."""
        return again(candidates, stage.weights)

    def register(self, samples: tuple[Samples, Samples], start: Pairs, stage: Stage) -> Candidate:
        """Register a candidate in one stage, whose samples are given, and measure its fit."""
        alignment = align(*samples, start, stage.sizes, stage.weights)
        fit, local = measure_fit(*samples, alignment, distances=stage.distances)
        images = samples[1].vertices[local.pairs.images]
        return Candidate(alignment, fit, images, local, self.missed(alignment))


def missed(
    source: SmoothSurface, positions: FloatArray, alignment: Alignment, landmarks: Points
) -> float:
    """Mean distance of displaced landmarks from where they should be; 0 without landmarks.

    Parameters
    ----------
    source
        What is displaced.
    positions
        (V, 3) vertices of the other surface, whose unit of length it is.
    alignment
        The displacement.
    landmarks
        Vertices of both.
    """
    here, there = landmarks
    if not len(here):
        return 0.0
    functions = source.spectrum.eigenfunctions[here, : alignment.size]
    displaced = functions @ alignment.coefficients
    return float(np.linalg.norm(displaced - positions[there], axis=1).mean())


FirstPairs = Callable[[tuple[Samples, Samples]], Iterable[Pairs]]
"""First pairs of candidates, given S and M samples of X and Y."""


def choose(
    task: Registering[SamplesT, StartT],
    first: Callable[[SamplesT], Iterable[StartT]],
    stages: Sequence[Stage],
    control: Control,
) -> list[Candidate]:
    """Register candidates in stages, each of which keeps the best that differ.

    Parameters
    ----------
    task
        The surfaces.
    first
        Where candidates begin, given the samples of the first stage.
    stages
        That candidates go through.
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
    for number, stage in enumerate(stages):
        samples = task.sampled(stage)
        starts = (first if number == 0 else task.again(kept, stage))(samples)
        found = [task.register(samples, start, stage) for start in control.in_time(starts, least=1)]
        if task.drops_missing:
            found = meeting_landmarks(found)
        kept = ranked(found, task.positions, stage.kept, stage.same)
    return kept


def from_hypotheses(task: Task, hypotheses: Sequence[Points]) -> FirstPairs:
    """Return the first pairs of hypotheses, of signs of eigenfunctions, and of a rotation."""
    surfaces = task.source, task.target
    return lambda samples: first_pairs(surfaces, samples, hypotheses)


def again(candidates: Iterable[Candidate], weights: Weights) -> FirstPairs:
    """Return the first pairs of candidates that go on from where they are."""

    def pairs(samples: tuple[Samples, Samples]) -> Iterator[Pairs]:
        return (one.alignment.pairs(*samples, weights) for one in candidates)

    return pairs


def mapped(task: Task, images: IntArray, back: IntArray) -> FirstPairs:
    """Return the first pairs of the candidate that maps of all vertices give.

    Parameters
    ----------
    task
        Surfaces of V and W vertices.
    images, back
        (V,) vertices of the target, and (W,) vertices of the source.
    """
    ours, theirs = task.source.mesh.vertices, task.target.mesh.vertices

    def pairs(samples: tuple[Samples, Samples]) -> Iterator[Pairs]:
        here, there = (one.vertices for one in samples)
        yield Pairs.of_all(
            nearest_points(theirs[images[here]], theirs[there]),
            nearest_points(ours[back[there]], ours[here]),
        )

    return pairs


def ranked(
    found: Sequence[Candidate], positions: FloatArray, most: int | None = None, same: float = SAME
) -> list[Candidate]:
    """Return candidates that differ, the best first: those that meet landmarks, by their score.

    Parameters
    ----------
    found
        Candidates at the same source samples.
    positions
        (V, 3) vertices that their images are among.
    most
        How many to return at most; all by default.
    same
        As of :class:`Stage`.
    """
    met = meeting([one.missed for one in found])
    order = sorted(zip(met, found, strict=True), key=lambda one: (not one[0], one[1].fit.score))
    rows = distinct((positions[one.images] for _, one in order), most, same)
    return [order[row][1] for row in rows]


def meeting_landmarks(found: Sequence[Candidate]) -> list[Candidate]:
    """Return the candidates that meet the landmarks as well as any, or nearly so."""
    return list(compress(found, meeting([one.missed for one in found])))


def meeting(missed: Sequence[float]) -> list[bool]:
    """Return which candidates meet the landmarks as well as any, or nearly so.

    Parameters
    ----------
    missed
        Mean distance of the displaced landmarks of each from where they should be, in √area.
    """
    least = min(missed, default=0.0)
    return [one <= least + LANDMARK_TOLERANCE for one in missed]


def distinct(maps: Iterable[FloatArray], most: int | None = None, same: float = SAME) -> list[int]:
    """Return which of several maps differ from all before them.

    Parameters
    ----------
    maps
        (V, 3) images of the same V vertices by each, at √area 1.
    most
        How many to return at most; all by default.
    same
        Mean distance between the images of maps that are the same.
    """
    every = list(maps)
    kept = np.empty((len(every), *every[0].shape)) if every else np.empty(0)
    chosen: list[int] = []
    for number, here in enumerate(every):
        if len(chosen) == most:
            break
        apart = np.linalg.norm(kept[: len(chosen)] - here, axis=2).mean(axis=1)
        if (apart > same).all():
            kept[len(chosen)] = here
            chosen.append(number)
    return chosen
