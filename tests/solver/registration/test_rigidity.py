"""As-rigid-as-possible displacements with overlapping neighbourhoods, against a plain version."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from solver.arrays import FloatArray
from solver.mesh import TriangleMesh
from solver.registration.rigidity import RigidDisplacement
from solver.shape.laplacian import laplacian
from tests.solver import shapes

LENGTH, WIDTH = 0.2, 0.1


@pytest.fixture(scope="module")
def mesh() -> TriangleMesh:
    return shapes.blob(2)


@pytest.fixture(scope="module")
def places(mesh: TriangleMesh) -> FloatArray:
    """A bent and noisy copy."""
    x, y, z = mesh.vertices.T
    bent = np.stack([x * np.cos(z) - y * np.sin(z), x * np.sin(z) + y * np.cos(z), z], axis=1)
    noisy: FloatArray = bent + 0.05 * np.random.default_rng(0).standard_normal(bent.shape)
    return noisy


class Plain:
    """The energy and its alternate minimisation, vertex by vertex, with dense matrices."""

    def __init__(self, mesh: TriangleMesh) -> None:
        stiffness, self.mass = laplacian(mesh)
        self.stiffness = stiffness.toarray()
        self.weights = np.diag(np.diag(self.stiffness)) - self.stiffness
        self.rest = mesh.vertices
        mass = np.diag(self.mass)
        self.neighbourhoods = np.linalg.inv(mass + WIDTH**2 * self.stiffness) @ mass

    def rotations(self, positions: FloatArray) -> list[FloatArray]:
        """One of each neighbourhood."""
        moments = []
        for i, row in enumerate(self.weights):
            edges, displaced = self.rest[i] - self.rest, positions[i] - positions
            moments.append(edges.T @ (row[:, None] * displaced))
        found = []
        for shares in self.neighbourhoods.T:
            left, _, right = np.linalg.svd(
                sum(share * one for share, one in zip(shares, moments, strict=True))
            )
            sign = np.sign(np.linalg.det(left @ right))
            found.append(left @ np.diag([1.0, 1.0, sign]) @ right)
        return found

    def step(self, positions: FloatArray, places: FloatArray) -> FloatArray:
        turns = np.einsum("ik,kab->iab", self.neighbourhoods, np.array(self.rotations(positions)))
        pull = self.mass / LENGTH**2
        right = pull[:, None] * places
        for i, j in np.argwhere(self.weights):
            edge = self.rest[i] - self.rest[j]
            right[i] += 0.5 * self.weights[i, j] * edge @ (turns[i] + turns[j])
        moved: FloatArray = np.linalg.solve(self.stiffness + np.diag(pull), right)
        return moved

    def energy(self, positions: FloatArray, places: FloatArray) -> float:
        """With the best rotations for the positions."""
        turns = np.array(self.rotations(positions))
        total = (self.mass[:, None] * (positions - places) ** 2).sum() / LENGTH**2
        for i, j in np.argwhere(self.weights):
            bent = positions[i] - positions[j] - (self.rest[i] - self.rest[j]) @ turns
            squares = self.neighbourhoods[i] @ (bent**2).sum(axis=1)
            total += 0.5 * self.weights[i, j] * squares
        return float(total)


def test_a_step_is_that_of_the_plain_implementation(mesh: TriangleMesh, places: FloatArray) -> None:
    plain, displacement = Plain(mesh), RigidDisplacement.of(mesh, laplacian(mesh), LENGTH, WIDTH)
    positions = mesh.vertices
    for _ in range(3):
        expected = plain.step(positions, places)
        positions = displacement.step(positions, places)
        np.testing.assert_allclose(positions, expected, atol=1e-8)


def test_the_energy_never_rises(mesh: TriangleMesh, places: FloatArray) -> None:
    plain, displacement = Plain(mesh), RigidDisplacement.of(mesh, laplacian(mesh), LENGTH, WIDTH)
    positions = mesh.vertices
    energies = [plain.energy(positions, places)]
    for _ in range(6):
        positions = displacement.step(positions, places)
        energies.append(plain.energy(positions, places))
    assert (np.diff(energies) <= 1e-9 * energies[0]).all()
    assert energies[-1] < 0.5 * energies[0]


def test_rigid_motions_are_fixed_points(mesh: TriangleMesh) -> None:
    turn = Rotation.from_rotvec([1.0, -2.0, 0.5]).as_matrix()
    moved = mesh.vertices @ turn + [3.0, 0.0, -1.0]
    found = RigidDisplacement.of(mesh, laplacian(mesh), LENGTH, WIDTH).step(moved, moved)
    np.testing.assert_allclose(found, moved, atol=1e-8)


def test_short_lengths_follow_places_and_long_ones_do_not(
    mesh: TriangleMesh, places: FloatArray
) -> None:
    near, far = (
        RigidDisplacement.of(mesh, laplacian(mesh), length, WIDTH).step(places, places)
        for length in (1e-3, 10.0)
    )
    np.testing.assert_allclose(near, places, atol=1e-3)
    assert np.abs(far - places).max() > 0.05
