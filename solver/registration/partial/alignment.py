"""Alignment of a whole surface to a part of it, in space, normals, spectrum and curvature.

As :mod:`solver.registration.alignment`, but for what a part lacks. It is the whole that is bent:
its eigenfunctions know nothing of the cuts. Averages of the mean curvature, which cuts hardly
change, are compared besides. Every point of the part has a partner, and the whole is
drawn by these pairs alone: what the part lacks is nearest to its edges, and would be drawn there.
Where the surfaces only overlap, neither is whole: a point of either has a partner only if the
partner's partner is near it, and the one that is bent is called the whole here, too. And the
functional map is not orthogonal: a smooth function on the part is the restriction of a
smooth function on the whole, so that each eigenfunction of the part is fitted by a combination of
those of the whole (Rodolà, Cosmo, Bronstein, Torsello and Cremers, "Partial functional
correspondence", CGF 36(1), 2017).
"""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np

from solver.arrays import FloatArray, IntArray, RealArray
from solver.functional_maps import FunctionalMap, mutual_nearest_points, nearest_points
from solver.registration.alignment import (
    LEAST_RIDGE_OF_FEW,
    Alignment,
    Pairs,
    WeightedBasis,
    Weights,
    embedding,
    fit_displacement,
    ridge_of,
)
from solver.registration.surface import Samples, SmoothSurface

WEIGHTS = Weights(spectrum=1.0, space=2.0, normals=0.3, curvature=0.2)
"""Of the embedding. Before curvatures were compared, errors were a fifth to a third more without
spectral coordinates, and no less with twice their weight. Of 14 hard ones of ``python -m
bench.partial --halves``, five were wrong without curvatures, two with a weight of 0.1, four with
0.3; of all 48, five with 0.15, four with 0.2."""

IN_SPACE = replace(WEIGHTS, spectrum=0.0, curvature=0.0)
"""Of the embedding in which a fit is measured: of what is registered, a distance in space."""

PARTNER_DISTANCE = 0.1
"""Distance over √area of the whole within which a point's partner's partner is near it."""

_RANK = 0.6
"""Eigenfunctions of the part, for each of the whole: there are as many below an eigenvalue as the
part's share of the area (Weyl's law), and a half to all of a surface is a part of interest. A
choice in this range."""


@dataclass(frozen=True, eq=False)
class PartSamples:
    """Samples of the part.

    Parameters
    ----------
    vertices
        (M,) vertices of the part.
    positions, normals
        (M, 3) not smoothed.
    functions
        (M, K) values of eigenfunctions, of mean square 1.
    surfaces
        The whole and the part.
    entire
        Whether every point of the part has a partner on the whole.
    """

    vertices: IntArray
    positions: FloatArray
    normals: FloatArray
    functions: FloatArray
    surfaces: tuple[SmoothSurface, SmoothSurface]
    entire: bool
    _curvatures: dict[float, FloatArray] = field(default_factory=dict, init=False, repr=False)

    @classmethod
    def at(
        cls,
        surfaces: tuple[SmoothSurface, SmoothSurface],
        vertices: IntArray,
        entire: bool,
    ) -> "PartSamples":
        """Return chosen vertices of the part as samples."""
        part = surfaces[1]
        return cls(
            vertices,
            part.mesh.vertices[vertices],
            part.normals[vertices],
            part.spectrum.eigenfunctions[vertices],
            surfaces,
            entire,
        )

    def curvatures(self, whole: Samples, scale: float) -> tuple[FloatArray, FloatArray]:
        """(S, m) and (M, m) standardised curvatures, those of the part as at the whole's scale.

        Parameters
        ----------
        whole
            S samples of the whole.
        scale
            √area of the whole in the part's unit.
        """
        ours, theirs = (surface.averages for surface in self.surfaces)
        if scale not in self._curvatures:
            # Of the last scale only: each candidate has its own, for all stages of its alignment.
            self._curvatures.clear()
            self._curvatures[scale] = theirs.standardised_by(ours, scale, self.vertices)
        return ours.standardised[whole.vertices], self._curvatures[scale]


def embed(
    whole: Samples, part: PartSamples, alignment: Alignment, scale: float, weights: Weights
) -> tuple[RealArray, RealArray]:
    """Embed both surfaces; lengths are those of the whole.

    Returns
    -------
    (S, m) of the displaced whole and (M, m) of the part, in single precision.
    """
    weights = replace(weights, space=weights.space / scale)
    images = functions = here = there = None
    if weights.spectrum:
        functional = alignment.functional_map
        images = functional.images(whole.eigenfunctions)
        functions = part.functions[:, : functional.size]
    if weights.curvature:
        here, there = part.curvatures(whole, scale)
    displaced = whole.surface(alignment.coefficients)
    return (
        embedding(*displaced, weights, images, here),
        embedding(part.positions, part.normals, weights, functions, there),
    )


def find_pairs(
    whole: Samples,
    part: PartSamples,
    alignment: Alignment,
    scale: float,
    weights: Weights,
    near: float = PARTNER_DISTANCE,
) -> Pairs:
    """Nearest neighbours in the embedding: of a part, or of both surfaces that overlap.

    Parameters
    ----------
    whole, part, alignment, scale, weights
        As for :func:`embed`.
    near
        Distance over √area of the whole within which a point's partner's partner is near it, of
        surfaces that overlap.
    """
    here, there = embed(whole, part, alignment, scale, weights)
    if part.entire:
        return Pairs.of_part(nearest_points(there, here), len(whole))
    images, back = mutual_nearest_points(here, there)
    apart = np.linalg.norm(whole.positions - whole.positions[back[images]], axis=1)
    away = np.linalg.norm(part.positions - part.positions[images[back]], axis=1)
    return Pairs(images, back, apart < near, away < near * scale)


def align_to_part(
    whole: Samples,
    part: PartSamples,
    alignment: Alignment,
    scale: float,
    sizes: Iterable[int],
    weights: Weights,
) -> Alignment:
    """Align a whole to a part from coarse to fine.

    Parameters
    ----------
    whole, part
        S and M samples; the part is of unit area.
    alignment
        To begin with.
    scale
        √area of the whole in the part's unit.
    sizes
        Numbers of eigenfunctions to go through.
    weights
        Of the embedding.
    """
    for size in sizes:
        pairs = find_pairs(whole, part, alignment, scale, weights)
        alignment = fit_to_part(whole, part, pairs, scale, size)
    return alignment


def fit_to_part(
    whole: Samples, part: PartSamples, pairs: Pairs, scale: float, size: int
) -> Alignment:
    """Fit a displacement and a functional map to pairs of samples.

    Parameters
    ----------
    whole, part
        S and M samples.
    pairs
        Of them.
    scale
        As for :func:`align_to_part`. The rotation of the alignment is multiplied by it.
    size
        Number of eigenfunctions.
    """
    k = min(size, whole.size)
    basis, ridge = WeightedBasis.of(whole, pairs, k), ridge_of(whole, k, LEAST_RIDGE_OF_FEW)
    coefficients, turn = fit_displacement(
        basis, whole.coefficients[:k], pairs.partners(part.positions, 3), ridge, scale
    )
    rank = min(max(int(_RANK * k), 4), part.functions.shape[1])
    matrix = basis.coefficients(pairs.partners(part.functions, rank), ridge).T
    return Alignment(coefficients, FunctionalMap(np.asarray(matrix)), turn)
