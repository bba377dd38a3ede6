"""Quality of a map between two shapes: change of signatures and of short chords, orientation."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial import KDTree

from solver.arrays import FloatArray, IntArray
from solver.mesh import signed_areas, vertex_normals
from solver.shape import Shape, euclidean_farthest_points
from solver.shape.descriptors import wave_kernel_signature
from solver.shape.laplacian import Spectrum

EIGENPAIRS = 100
"""Eigenpairs of the finest functional maps."""

_SOURCE_SAMPLES, _TARGET_SAMPLES = 500, 2000
"""Samples of X and of Y by which maps are refined and compared. These and the next two are chosen
on generated shapes; `bench.dense` measures them."""

_FITTED_SAMPLES = 1500
"""Samples of X to which the chosen map is fitted."""

_NEIGHBOURS = 8
"""Neighbours of a sample by commute times, with which it forms chords and triangles."""


def unit_spectrum(shape: Shape) -> Spectrum:
    """Spectrum of a shape scaled to unit area."""
    return shape.spectrum(EIGENPAIRS).scaled(1.0 / shape.size)


@dataclass(frozen=True, eq=False)
class ComparedShape:
    """A shape of unit area, with its structures at samples spread over it.

    Parameters
    ----------
    shape, spectrum
        The shape, and its spectrum on unit area.
    signatures
        (V, m) wave kernel signatures.
    embedded, sampled_signatures
        (S, k) eigenfunctions and (S, m) signatures at the samples.
    positions, normals
        (S, 3) positions of the samples, and outward normals there.
    """

    shape: Shape
    spectrum: Spectrum
    signatures: FloatArray
    embedded: FloatArray
    sampled_signatures: FloatArray
    positions: FloatArray
    normals: FloatArray

    @classmethod
    def of(cls, shape: Shape, count: int) -> "ComparedShape":
        """Sample a shape."""
        spectrum = unit_spectrum(shape)
        # In space: this is quick, and even on the surface of a body.
        samples = euclidean_farthest_points(shape.surface.vertices, min(count, shape.n_vertices))
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
    def of_target(cls, shape: Shape) -> "ComparedShape":
        """Sample a target, with which several shapes can be compared."""
        return cls.of(shape, _TARGET_SAMPLES)

    def first(self, count: int) -> "ComparedShape":
        """Return the shape with its first samples only, which are those of a shorter sampling."""
        return replace(
            self,
            embedded=self.embedded[:count],
            sampled_signatures=self.sampled_signatures[:count],
            positions=self.positions[:count],
            normals=self.normals[:count],
        )

    @cached_property
    def coefficients(self) -> FloatArray:
        """(k, m) coefficients of the signatures in the eigenfunctions."""
        return self.spectrum.eigenfunctions.T @ (self.spectrum.mass[:, None] * self.signatures)

    def heat_coefficients(self, vertices: IntArray, time: float, size: int) -> FloatArray:
        """(size, n) coefficients of the heat kernels h_t(x, ·) of (2) at n vertices x."""
        decay = np.exp(-self.spectrum.eigenvalues[:size] * time)
        coefficients: FloatArray = (self.spectrum.eigenfunctions[vertices, :size] * decay).T
        return coefficients


class Comparison:
    """Two shapes at their samples, between which maps are measured.

    Parameters
    ----------
    source, target
        The shapes X and Y. Y may be given with its samples, to share them between comparisons.

    Attributes
    ----------
    source, target
        X with 500 samples and Y with 2000.
    """

    def __init__(self, source: Shape, target: "Shape | ComparedShape") -> None:
        self.target = (
            target if isinstance(target, ComparedShape) else ComparedShape.of_target(target)
        )
        itself = source is self.target.shape
        self.source = (
            self.target.first(_SOURCE_SAMPLES)
            if itself
            else ComparedShape.of(source, _SOURCE_SAMPLES)
        )
        count = min(_NEIGHBOURS + 1, len(self.source.positions))
        # Neighbours by commute times: a hand on a hip is near it in space only.
        spectral = self.source.embedded[:, 1:] / np.sqrt(self.source.spectrum.eigenvalues[1:])
        near = np.asarray(KDTree(spectral).query(spectral, k=count)[1])[:, 1:]
        self._ends = np.repeat(np.arange(len(near)), near.shape[1]), near.ravel()
        one, two = np.triu_indices(near.shape[1], 1)
        middle = np.repeat(np.arange(len(near)), len(one))
        self._triples = middle, near[:, one].ravel(), near[:, two].ravel()
        # These are the same for all maps.
        self._chords = self._lengths(self.source.positions)
        self._areas = signed_areas(self.source.positions, self.source.normals, *self._triples)

    @cached_property
    def fitted(self) -> FloatArray:
        """(S, k) eigenfunctions at more samples of X, which begin with the compared ones."""
        shape = self.source.shape
        samples = euclidean_farthest_points(
            shape.surface.vertices, min(_FITTED_SAMPLES, shape.n_vertices)
        )
        return self.source.spectrum.eigenfunctions[samples]

    def differences(self, partners: IntArray) -> tuple[float, float]:
        """Mean change of the signature, and root mean square change of a chord's length.

        Parameters
        ----------
        partners
            (S,) index of the sample of Y that is the image of each sample of X.

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

    def orientation_score(self, partners: IntArray) -> float:
        """Correlation of signed areas on X and Y: 1 if orientation is preserved, -1 if reversed.

        The areas are those of small triangles between neighbouring samples, negative where their
        corners are in clockwise order as seen from outside. A map and its mirror image differ in
        sign, intrinsically in nothing else; a mixture of both is near 0.

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
