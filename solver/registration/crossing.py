"""Crossing of candidates: each is taken where it fits better.

A candidate is often right on one half of a body and wrong on the other, and another one the other
way round. The difference of their local fits says which is better round each sample, and a minimum
cut where to change from one to the other. From the images that are chosen there, a new candidate
begins. Compare the crossover of genetic algorithms (Holland, "Adaptation in natural and artificial
systems", 1975) and fusion moves (Lempitsky, Rother, Roth, Blake, IEEE TPAMI 32(8), 2010).
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from solver.control import Control
from solver.functional_maps import mutual_nearest_points
from solver.registration.alignment import Pairs
from solver.registration.choice import COARSE, Candidate, Task, ranked
from solver.registration.fit import worse_by
from solver.registration.seams import neighbours_of, takes_second
from solver.registration.surface import Samples

_STAGE = replace(COARSE[-1], sizes=COARSE[-1].sizes[-2:])
"""Stage in which candidates are crossed. Finer ones can say more of what fits nearly, and are too
stiff to become right."""

_PARENTS = 6
"""Best candidates that are crossed with all others. A choice: of 32, these are up to 171 pairs,
each with a minimum cut and an alignment."""

_GENERATIONS = 2
"""How often candidates are crossed, each time with those that came of it. A choice: each
time takes as long as the first at most."""

_FEW = 0.05
"""Share of the samples that has to come from each of both."""


Crossed = set[frozenset[Candidate]]
"""Pairs of candidates that are crossed already."""


def cross(
    task: Task, candidates: Sequence[Candidate], crossed: Crossed, control: Control
) -> list[Candidate]:
    """Cross candidates with one another for some generations.

    Parameters
    ----------
    task
        The surfaces.
    candidates
        Of the coarse stages, the best first.
    crossed
        Pairs that are left out, to which those of this call are added.
    control
        May cancel; past its deadline, fewer are crossed.

    Returns
    -------
    The best of all that differ, the best first.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    samples = task.sampled(_STAGE)
    found = list(candidates[: _STAGE.kept])
    for _ in range(_GENERATIONS):
        children = [
            task.register(samples, pairs, _STAGE)
            for pairs in control.in_time(crossed_pairs(samples, found, crossed))
        ]
        found = ranked([*found, *children], task.positions, _STAGE.kept)
    return found


def crossed_pairs(
    samples: tuple[Samples, Samples], candidates: Sequence[Candidate], crossed: Crossed
) -> Iterator[Pairs]:
    """Yield pairs of the best candidates crossed with each of the others.

    Parameters
    ----------
    samples
        That the candidates were measured at.
    candidates
        The best first.
    crossed
        As for :func:`cross`.
    """
    source, target = samples
    embedded = [one.alignment.embed(source, target, _STAGE.weights) for one in candidates]
    images = [target.positions[one.local.pairs.images] for one in candidates]
    fits = [one.local.densities for one in candidates]
    neighbours = neighbours_of(source)
    for first, second in uncrossed(candidates, crossed):
        worse = worse_by(fits[first], fits[second])
        taken = takes_second(worse, neighbours, images[first], images[second])
        if _FEW <= taken.mean() <= 1.0 - _FEW:
            ours = np.where(taken[:, None], embedded[second][0], embedded[first][0])
            yield Pairs.of_all(*mutual_nearest_points(ours, embedded[first][1]))


def uncrossed(candidates: Sequence[Candidate], crossed: Crossed) -> Iterator[tuple[int, int]]:
    """Yield indices of the best candidates and of others that they are not crossed with yet.

    Parameters
    ----------
    candidates
        The best first.
    crossed
        As for :func:`cross`.
    """
    for first, one in enumerate(candidates[:_PARENTS]):
        for second, other in enumerate(candidates[first + 1 :], first + 1):
            pair = frozenset((one, other))
            if pair not in crossed:
                crossed.add(pair)
                yield first, second
