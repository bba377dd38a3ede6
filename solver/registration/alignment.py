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
from functools import cached_property

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray, RealArray
from solver.functional_maps import FunctionalMap, mutual_nearest_points
from solver.kernel import kernel
from solver.mesh import nearest_rotations
from solver.registration.surface import Samples

RIDGE = 0.01
"""Ridge of displacements, and of functional maps to parts. From 0.1 to 0.0001, errors change by a
fiftieth; of parts, with ten times or a tenth of it, by a tenth."""

LEAST_RIDGE = 1e-9
"""Least ridge, which keeps the equations regular where samples are fewer than eigenfunctions."""

LEAST_RIDGE_OF_FEW = 1e-6
"""The same where pairs are few, or on a part of the surface alone."""


@dataclass(frozen=True)
class Weights:
    """Weights of the parts of the embedding, of unit area.

    Parameters
    ----------
    spectrum
        Of the k spectral coordinates together, whose mean square is 1.
    space
        Of positions.
    normals
        Of unit normals.
    curvature
        Of standardised curvatures, for each diffusion time.
    """

    spectrum: float
    space: float
    normals: float
    curvature: float = 0.0


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
    covered, met
        (S,) and (M,) whether these are pairs: what has no partner on the other surface is left out.
    """

    images: IntArray
    back: IntArray
    covered: BoolArray
    met: BoolArray

    @classmethod
    def of_all(cls, images: IntArray, back: IntArray) -> "Pairs":
        """Return the pairs of all samples of both."""
        return cls(images, back, *(np.ones(len(one), dtype=np.bool_) for one in (images, back)))

    @classmethod
    def of_part(cls, back: IntArray, source_samples: int) -> "Pairs":
        """Pairs of all target samples, and of no others of the source.

        Parameters
        ----------
        back
            (M,) source samples.
        source_samples
            Number S of source samples.
        """
        nothing = np.zeros(source_samples, dtype=np.int64)
        return cls(nothing, back, nothing > 0, np.ones(len(back), dtype=np.bool_))

    @cached_property
    def rows(self) -> IntArray | slice:
        """The P source samples that are in a pair; a slice where all are."""
        weights = self._sample_weights
        return slice(None) if weights.all() else np.flatnonzero(weights)

    @property
    def weights(self) -> FloatArray:
        """(P, 1) weights of these samples; each direction has ½ in all."""
        return self._sample_weights[self.rows, None]

    def partners(self, values: FloatArray, k: int) -> FloatArray:
        """(P, k) weighted means of the first k of (M, K) values over all pairs of each sample.

        Fits of least squares to these means, with `weights`, are those to all pairs.
        """
        sums = _sums(self.images, self.back, self.covered, self.met, *self._pair_weights, values, k)
        return sums[self.rows] / self.weights

    @cached_property
    def _pair_weights(self) -> tuple[float, float]:
        """Weights of a pair of either direction."""
        ours, theirs = (0.5 / max(int(one.sum()), 1) for one in (self.covered, self.met))
        return ours, theirs

    @cached_property
    def _sample_weights(self) -> FloatArray:
        """(S,) weights of the source samples."""
        ours, theirs = self._pair_weights
        counts = np.bincount(self.back[self.met], minlength=len(self.images))
        weights: FloatArray = ours * self.covered + theirs * counts
        return weights


@kernel
def _sums(
    images: IntArray,
    back: IntArray,
    covered: BoolArray,
    met: BoolArray,
    ours: float,
    theirs: float,
    values: FloatArray,
    k: int,
) -> FloatArray:
    """(S, k) weighted sums of the first k values over all pairs of each source sample."""
    sums = np.zeros((len(images), k))
    for i in range(len(images)):
        if covered[i]:
            for d in range(k):
                sums[i, d] = ours * values[images[i], d]
    for j in range(len(back)):
        if met[j]:
            for d in range(k):
                sums[back[j], d] += theirs * values[j, d]
    return sums


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
    ) -> tuple[RealArray, RealArray]:
        """Embed both surfaces.

        Returns
        -------
        (S, 6 + k) of the displaced source and (M, 6 + k) of the target, in single precision.
        """
        displaced = source.surface(self.coefficients)
        return self.embed_source(source, displaced, weights), self.embed_target(target, weights)

    def embed_source(
        self, source: Samples, displaced: tuple[FloatArray, FloatArray], weights: Weights
    ) -> RealArray:
        """(S, 6 + k) embedding of the source with given displaced positions and normals."""
        return embedding(*displaced, weights, self.functional_map.images(source.eigenfunctions))

    def embed_target(self, target: Samples, weights: Weights) -> RealArray:
        """(M, 6 + k) embedding of the target, which depends on numbers of eigenfunctions alone."""
        k = self.functional_map.size
        key = (k, self.size, weights.spectrum, weights.space, weights.normals)
        if key not in target.embedded:
            functions = target.eigenfunctions[:, :k]
            target.embedded[key] = embedding(*target.smoothed(self.size), weights, functions)
        return target.embedded[key]

    def pairs(self, source: Samples, target: Samples, weights: Weights) -> Pairs:
        """Nearest neighbours in the embedding."""
        return Pairs.of_all(*mutual_nearest_points(*self.embed(source, target, weights)))


def embedding(
    positions: FloatArray,
    normals: FloatArray,
    weights: Weights,
    functions: FloatArray | None = None,
    curvatures: FloatArray | None = None,
) -> RealArray:
    """Embed points of a surface, in single precision.

    Parameters
    ----------
    positions, normals
        (S, 3) each.
    weights
        Of the parts.
    functions
        (S, k) spectral coordinates; without them, there are none.
    curvatures
        (S, m) standardised curvatures; without them, there are none.

    Returns
    -------
    (S, 6 + k + m): positions and normals, which rule out most neighbours, then the others.
    """
    parts = [weights.space * positions, weights.normals * normals]
    if functions is not None and functions.shape[1]:
        parts.append(weights.spectrum / np.sqrt(functions.shape[1]) * functions)
    if curvatures is not None:
        parts.append(weights.curvature * curvatures)
    return np.hstack(parts, dtype=np.float32)


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
    basis = WeightedBasis.of(source, pairs, k)
    displacement = fit_displacement(
        basis,
        source.coefficients[:k],
        pairs.partners(target.smoothed(k)[0], 3),
        ridge_of(source, k, LEAST_RIDGE),
    )
    there = pairs.partners(target.eigenfunctions, k)
    left, _, right = np.linalg.svd((basis.weighted @ there).T)
    return Alignment(displacement[0], FunctionalMap(left @ right), displacement[1])


def ridge_of(source: Samples, k: int, least: float) -> FloatArray:
    """(k,) ridge of a fit in the first k eigenfunctions of a source, `least` at least."""
    return RIDGE * source.eigenvalues[:k] / max(float(source.eigenvalues[-1]), least) + least


@dataclass(frozen=True, eq=False)
class WeightedBasis:
    """Eigenfunctions of a surface at some of its points, to be fitted by least squares.

    Parameters
    ----------
    functions
        (P, k) their values.
    weights
        (P, 1) of the points.
    """

    functions: FloatArray
    weights: FloatArray

    @classmethod
    def of(cls, source: Samples, pairs: Pairs, k: int) -> "WeightedBasis":
        """Return the first k eigenfunctions at the source samples of pairs."""
        return cls(source.eigenfunctions[pairs.rows, :k], pairs.weights)

    @cached_property
    def weighted(self) -> FloatArray:
        """(k, P) values times weights."""
        return (self.functions * self.weights).T

    @cached_property
    def gram(self) -> FloatArray:
        """(k, k) weighted scalar products of the eigenfunctions."""
        products: FloatArray = self.weighted @ self.functions
        return products

    def coefficients(self, values: FloatArray, ridge: FloatArray) -> FloatArray:
        """(k, d) coefficients that fit (P, d) values, with a (k,) ridge."""
        found = np.linalg.solve(self.gram + np.diag(ridge), self.weighted @ values)
        return np.asarray(found, dtype=np.float64)


def fit_displacement(
    basis: WeightedBasis,
    coefficients: FloatArray,
    goals: FloatArray,
    ridge: FloatArray,
    scale: float = 1.0,
) -> tuple[FloatArray, FloatArray]:
    """Rotate and move points of a surface onto given ones, then displace them smoothly.

    Parameters
    ----------
    basis
        k eigenfunctions of the surface at P points.
    coefficients
        (k, 3) coefficients of its positions.
    goals
        (P, 3) where the points are to go.
    ridge
        (k,) of the displacement.
    scale
        By which lengths of the surface are multiplied.

    Returns
    -------
    (k, 3) coefficients of the displaced surface, and (3, 3) its rotation times the scale.
    """
    functions, weights = basis.functions, basis.weights
    here = functions @ coefficients
    turn = scale * rotation_onto(here, goals, weights)
    turned = coefficients @ turn
    # The first eigenfunction is constant: the translation is free of the ridge.
    turned[0] += (weights * (goals - here @ turn)).sum(axis=0) / (weights.sum() * functions[0, 0])
    return turned + basis.coefficients(goals - functions @ turned, ridge), turn


def rotation_onto(here: FloatArray, there: FloatArray, weights: FloatArray) -> FloatArray:
    """Rotation of corresponding points onto one another: Procrustes without reflection.

    Parameters
    ----------
    here, there
        (S, 3) points.
    weights
        (S, 1) weights of the points.

    Returns
    -------
    (3, 3) R of determinant 1: centred points x go to x R.
    """
    total = weights.sum()
    centred, centred_there = (one - (weights * one).sum(axis=0) / total for one in (here, there))
    turn: FloatArray = nearest_rotations(((weights * centred).T @ centred_there)[None])[0]
    return turn
