"""Rotations nearest to matrices, beside the singular value decomposition."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver.arrays import FloatArray
from solver.mesh import nearest_rotations

COUNT = 50


def plain(moments: FloatArray) -> FloatArray:
    """The polar factor, the least singular vector turned round where it were a reflection."""
    left, _, right = np.linalg.svd(moments)
    left[:, :, 2] *= np.sign(np.linalg.det(left @ right))[:, None]
    turns: FloatArray = left @ right
    return turns


def nearness(turns: FloatArray, moments: FloatArray) -> FloatArray:
    """tr(Rᵀ M) / ‖M‖."""
    found: FloatArray = (turns * moments).sum(axis=(1, 2)) / np.linalg.norm(moments, axis=(1, 2))
    return found


def moments_of(seed: int, rank: int, scale: float) -> FloatArray:
    rng = np.random.default_rng(seed)
    return scale * rng.normal(size=(COUNT, 3, rank)) @ rng.normal(size=(COUNT, rank, 3))


@given(
    st.integers(0, 2**32 - 1), st.sampled_from([1, 2, 3]), st.sampled_from([1e-100, 1e-9, 1.0, 1e9])
)
def test_no_rotation_is_nearer(seed: int, rank: int, scale: float) -> None:
    moments = moments_of(seed, rank, scale)
    turns = nearest_rotations(moments)
    identity = np.broadcast_to(np.eye(3), turns.shape)
    np.testing.assert_allclose(turns @ turns.transpose(0, 2, 1), identity, atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(turns), 1.0, atol=1e-12)
    np.testing.assert_allclose(
        nearness(turns, moments), nearness(plain(moments), moments), atol=1e-10
    )


@given(st.integers(0, 2**32 - 1))
def test_rotations_are_found_again_from_scaled_axes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    turns = plain(rng.normal(size=(COUNT, 3, 3)))
    stretch = rng.uniform(0.2, 2.0, (COUNT, 3, 1)) * plain(rng.normal(size=(COUNT, 3, 3)))
    symmetric = stretch.transpose(0, 2, 1) @ stretch
    np.testing.assert_allclose(nearest_rotations(symmetric @ turns), turns, atol=1e-9)


@pytest.mark.parametrize("axis", range(3))
def test_half_turns_are_found(axis: int) -> None:
    turn = -np.eye(3)
    turn[axis, axis] = 1.0
    found = nearest_rotations((np.diag([1.0, 2.0, 3.0]) @ turn)[None])
    np.testing.assert_allclose(found[0], turn, atol=1e-12)


def test_undetermined_rotations_are_the_identity() -> None:
    undetermined = np.array([np.zeros((3, 3)), np.full((3, 3), np.inf)])
    np.testing.assert_array_equal(nearest_rotations(undetermined), [np.eye(3)] * 2)
