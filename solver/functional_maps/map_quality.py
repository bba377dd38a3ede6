"""What a map between two shapes does to signatures, to short chords, and to orientation."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial import KDTree

from solver.arrays import FloatArray, IntArray
from solver.mesh import signed_areas, vertex_normals
from solver.shape import Shape, spread_in_space
from solver.shape.descriptors import wave_kernel_signature
from solver.shape.laplacian import Spectrum

EIGENPAIRS = 100
_COMPARED = 500, 2000
"""Points of X and of Y by which maps are compared, and refined until one is chosen."""

_FITTED = 1500
"""Points of X to which the one chosen is fitted at last."""

_NEIGHBOURS = 8


def unit_spectrum(shape: Shape) -> Spectrum:
    """Spectrum of a shape as if its area were 1."""
    return shape.spectrum(EIGENPAIRS).scaled(1.0 / shape.size)


@dataclass(frozen=True, eq=False)
class Side:
    """A shape of unit area: its eigenfunctions, and what is compared at points spread over it.

    Parameters
    ----------
    shape, spectrum
        The shape, and its spectrum on unit area.
    signatures
        (V, m) wave kernel signatures.
    embedded, sampled_signatures
        (S, k) eigenfunctions and (S, m) signatures at points spread over the shape.
    positions, normals
        (S, 3) where these are, and which way is out there.
    """

    shape: Shape
    spectrum: Spectrum
    signatures: FloatArray
    embedded: FloatArray
    sampled_signatures: FloatArray
    positions: FloatArray
    normals: FloatArray

    @classmethod
    def of(cls, shape: Shape, count: int) -> "Side":
        """Look at a shape at some of its points."""
        spectrum = unit_spectrum(shape)
        # In space, which is quick, and as even on the surface of a body as along it.
        samples = spread_in_space(shape.surface.vertices, min(count, shape.n_vertices))
        signatures = wave_kernel_signature(spectrum)
        return cls(
            shape,
            spectrum,
            signatures,
            spectrum.eigenfunctions[samples],
            signatures[samples],
            shape.surface.vertices[samples] / shape.size,
            vertex_normals(shape.surface.vertices, shape.surface.faces)[samples],
        )

    @classmethod
    def of_target(cls, shape: Shape) -> "Side":
        """Look at a target, with which several shapes can be compared."""
        return cls.of(shape, _COMPARED[1])

    def first(self, count: int) -> "Side":
        """Look at the first of its points only, which are those of a sampling of so many."""
        return replace(
            self,
            embedded=self.embedded[:count],
            sampled_signatures=self.sampled_signatures[:count],
            positions=self.positions[:count],
            normals=self.normals[:count],
        )

    @cached_property
    def coefficients(self) -> FloatArray:
        """(k, m) of the signatures, in the eigenfunctions."""
        return self.spectrum.eigenfunctions.T @ (self.spectrum.mass[:, None] * self.signatures)

    def heat_coefficients(self, vertices: IntArray, time: float, size: int) -> FloatArray:
        """(size, n) of the heat kernels h_t(x, ·) of (2), from some vertices x."""
        decay = np.exp(-self.spectrum.eigenvalues[:size] * time)
        coefficients: FloatArray = (self.spectrum.eigenfunctions[vertices, :size] * decay).T
        return coefficients


class Comparison:
    """What a map does to signatures, to short chords, and to the orientation of two shapes.

    Parameters
    ----------
    source, target
        The shapes X and Y, of which 500 and 2000 points are looked at. What is known of Y from
        another comparison may be given instead.

    Attributes
    ----------
    source, target
        What is known of them there.
    """

    def __init__(self, source: Shape, target: "Shape | Side") -> None:
        self.target = target if isinstance(target, Side) else Side.of_target(target)
        itself = source is self.target.shape
        self.source = self.target.first(_COMPARED[0]) if itself else Side.of(source, _COMPARED[0])
        count = min(_NEIGHBOURS + 1, len(self.source.positions))
        # Near by commute times: a hand on a hip is near it in space alone.
        spectral = self.source.embedded[:, 1:] / np.sqrt(self.source.spectrum.eigenvalues[1:])
        near = np.asarray(KDTree(spectral).query(spectral, k=count)[1])[:, 1:]
        self._ends = np.repeat(np.arange(len(near)), near.shape[1]), near.ravel()
        one, two = np.triu_indices(near.shape[1], 1)
        middle = np.repeat(np.arange(len(near)), len(one))
        self._triples = middle, near[:, one].ravel(), near[:, two].ravel()
        # The same for every map that is compared.
        self._chords = self._lengths(self.source.positions)
        self._areas = signed_areas(self.source.positions, self.source.normals, *self._triples)

    @cached_property
    def fitted(self) -> FloatArray:
        """(S, k) eigenfunctions at more points of X, those looked at first."""
        shape = self.source.shape
        samples = spread_in_space(shape.surface.vertices, min(_FITTED, shape.n_vertices))
        return self.source.spectrum.eigenfunctions[samples]

    def differences(self, partners: IntArray) -> tuple[float, float]:
        """Mean change of the signature, and root mean square change of a chord's length.

        Parameters
        ----------
        partners
            (S,) the point of Y, of those looked at, to which each one of X goes.

        Returns
        -------
        The second in units of √area.
        """
        x, y = self.source, self.target
        signature = x.sampled_signatures - y.sampled_signatures[partners]
        chord = self._chords - self._lengths(y.positions[partners])
        return (
            float(np.linalg.norm(signature, axis=1).mean()),
            float(np.sqrt((chord**2).mean())),
        )

    def orientation(self, partners: IntArray) -> float:
        """Whether the surface is turned over, as by a reflection: 1 if it is nowhere, -1 if it is.

        Correlation, over small triangles between neighbouring points, of their areas on X and on
        Y, each negative where its corners go round clockwise as seen from outside. A map that is
        right keeps orientation, its mirror image reverses it, and intrinsically there is no
        difference. A mixture of both is near 0.

        Parameters
        ----------
        partners
            (S,) as for :meth:`differences`.
        """
        y, here = self.target, self._areas
        there = signed_areas(y.positions[partners], y.normals[partners], *self._triples)
        norms = float(np.sqrt((here**2).sum() * (there**2).sum()))
        return float((here * there).sum()) / norms if norms > 0.0 else 0.0

    def _lengths(self, positions: FloatArray) -> FloatArray:
        here, there = self._ends
        lengths: FloatArray = np.linalg.norm(positions[here] - positions[there], axis=1)
        return lengths
