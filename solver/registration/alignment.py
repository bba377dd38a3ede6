"""Alignment of a source to a target in spectrum, space and normals, from coarse to fine.

Compare Eisenberger, Lähner and Cremers, "Smooth Shells: Multi-scale shape registration with
functional maps", CVPR 2020. For growing k, both surfaces are smoothed to k eigenfunctions. To the
images so far are fitted a displacement of the source, in its own first k eigenfunctions, and an
orthogonal functional map. Both shapes are then embedded as (spectral coordinates, positions of the
displaced source, its normals), and nearest neighbours give the next images. Displaced surfaces are
turned and bent but never reflected, so that images on the wrong side have the wrong normals.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.functional_maps import FunctionalMap, mutual_nearest_points
from solver.registration.rotations import nearest_rotations
from solver.registration.surface import Samples

_RIDGE = 0.01
"""Ridge of displacements. From 0.1 to 0.0001, errors change by a fiftieth."""

_LEAST = 1e-9
"""Least ridge, which keeps the equations regular where samples are fewer than eigenfunctions."""


@dataclass(frozen=True)
class Weights:
    """Weights of the three parts of the embedding, of unit area.

    Parameters
    ----------
    spectrum
        Of the k spectral coordinates together, whose mean square is 1.
    space
        Of positions.
    normals
        Of unit normals.
    """

    spectrum: float
    space: float
    normals: float


# Chosen on generated people and animals: `python -m bench.dense`.
GLOBAL = Weights(spectrum=0.3, space=2.0, normals=0.3)
"""While the pose is not known, so that positions are far off."""

LOCAL = Weights(spectrum=0.3, space=4.0, normals=0.2)
"""Once the displaced source is near the target."""


@dataclass(frozen=True, eq=False)
class Pairs:
    """Nearest neighbours of two samplings in both directions.

    Parameters
    ----------
    images
        (S,) target sample of each source sample.
    back
        (M,) source sample of each target sample. Without these, a part of the target that no
        source sample goes to would attract nothing.
    """

    images: IntArray
    back: IntArray


@dataclass(frozen=True, eq=False)
class Alignment:
    """A displaced source and the functional map to a target, in k eigenfunctions of both.

    Parameters
    ----------
    coefficients
        (k, 3) coefficients of the displaced source's positions in the source's eigenfunctions.
    functional_map
        Orthogonal, of size k or less.
    turn
        (3, 3) rotation R of the source, x ↦ x R, to which the displacement is added.
    """

    coefficients: FloatArray
    functional_map: FunctionalMap
    turn: FloatArray

    @property
    def size(self) -> int:
        """Number k of eigenfunctions of the displacement."""
        return len(self.coefficients)

    def embed(
        self, source: Samples, target: Samples, weights: Weights
    ) -> tuple[FloatArray, FloatArray]:
        """Embed both surfaces.

        Returns
        -------
        (S, k + 6) of the displaced source and (M, k + 6) of the target.
        """
        k = self.functional_map.size
        spectrum = weights.spectrum / np.sqrt(k)
        positions, normals = source.surface(self.coefficients)
        there, there_normals = target.smoothed(self.size)
        return (
            np.hstack(
                [
                    spectrum * self.functional_map.images(source.eigenfunctions),
                    weights.space * positions,
                    weights.normals * normals,
                ]
            ),
            np.hstack(
                [
                    spectrum * target.eigenfunctions[:, :k],
                    weights.space * there,
                    weights.normals * there_normals,
                ]
            ),
        )

    def pairs(self, source: Samples, target: Samples, weights: Weights) -> Pairs:
        """Nearest neighbours in the embedding, in single precision."""
        ours, theirs = self.embed(source, target, weights)
        return Pairs(*mutual_nearest_points(ours.astype(np.float32), theirs.astype(np.float32)))


def align(
    source: Samples,
    target: Samples,
    pairs: Pairs,
    sizes: Iterable[int],
    weights: Weights,
) -> Alignment:
    """Align a source to a target from coarse to fine.

    Parameters
    ----------
    source, target
        S and M samples.
    pairs
        To begin with.
    sizes
        Numbers of eigenfunctions to go through, at least one.
    weights
        Of the embedding.

    Returns
    -------
    The alignment of the last size.
    """
    found: Alignment | None = None
    for size in sizes:
        if found is not None:
            pairs = found.pairs(source, target, weights)
        found = fit_alignment(source, target, pairs, size)
    assert found is not None
    return found


def fit_alignment(source: Samples, target: Samples, pairs: Pairs, size: int) -> Alignment:
    """Fit a displacement and a functional map to pairs of samples.

    The displacement minimises the mean square of distances between pairs plus a ridge times
    Σ λ_i ‖c_i‖² / λ_K: smooth displacements are preferred where the pairs leave a choice. Pairs of
    both directions weigh the same together.

    Parameters
    ----------
    source, target
        S and M samples.
    pairs
        Nearest neighbours of both.
    size
        Number of eigenfunctions; all there are, if it is greater.
    """
    k = min(size, source.size, target.size)
    n, m = len(source), len(target)
    rows = np.concatenate([np.arange(n), pairs.back])
    columns = np.concatenate([pairs.images, np.arange(m)])
    weights = np.concatenate([np.full(n, 0.5 / n), np.full(m, 0.5 / m)])[:, None]
    there, here = target.smoothed(k)[0][columns], source.smoothed(k)[0][rows]
    turn = rotation_onto(here, there, weights)
    coefficients = source.coefficients[:k] @ turn
    ours, theirs = source.eigenfunctions[rows, :k], target.eigenfunctions[columns, :k]
    weighted = (ours * weights).T
    ridge = _RIDGE * source.eigenvalues[:k] / max(float(source.eigenvalues[-1]), _LEAST)
    gram = weighted @ ours + np.diag(ridge + _LEAST)
    displacement = np.linalg.solve(gram, weighted @ (there - ours @ coefficients))
    left, _, right = np.linalg.svd((weighted @ theirs).T)
    return Alignment(coefficients + displacement, FunctionalMap(left @ right), turn)


def rotation_onto(here: FloatArray, there: FloatArray, weights: FloatArray) -> FloatArray:
    """Rotation of corresponding points onto one another: Procrustes without reflection.

    Parameters
    ----------
    here, there
        (S, 3) points.
    weights
        (S, 1) weights of the points, with sum 1.

    Returns
    -------
    (3, 3) R of determinant 1: centred points x go to x R.
    """
    centred, centred_there = (one - (weights * one).sum(axis=0) for one in (here, there))
    turn: FloatArray = nearest_rotations(((weights * centred).T @ centred_there)[None])[0]
    return turn
