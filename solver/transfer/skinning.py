"""Skinning weights: the shares of joints in the movement of each vertex, of sum 1."""

from collections.abc import Mapping, Sequence

import numpy as np

from solver.arrays import FloatArray
from solver.errors import OptionError, TransferError


def normalised_weights(weights: FloatArray) -> FloatArray:
    """Divide the weights of each vertex by their sum.

    Parameters
    ----------
    weights
        (V, J) of J joints.

    Returns
    -------
    (V, J) with rows of sum 1; rows of zeros, of vertices that none of the joints moves, stay, as do
    those with nan.

    Raises
    ------
    TransferError
        A weight is negative.
    """
    if (weights < 0.0).any():
        row, joint = np.argwhere(weights < 0.0)[0]
        raise TransferError(f"the weight of joint {joint} at vertex {row} is negative")
    # The greatest first, so that sums of great weights stay finite.
    scaled = weights / np.where(weights > 0.0, weights, 0.0).max(axis=1, initial=1e-300)[:, None]
    sums = scaled.sum(axis=1, keepdims=True)
    shares: FloatArray = scaled / np.where(sums == 0.0, 1.0, sums)
    return shares


def strongest_weights(weights: FloatArray, count: int | None) -> FloatArray:
    """Keep the greatest weights of each vertex, of equal ones the first; set the others to zero.

    Parameters
    ----------
    weights
        (V, J).
    count
        How many, at least one; None for all. glTF has sets of four.

    Raises
    ------
    OptionError
        `count` is less than one.
    """
    if count is not None and count < 1:
        raise OptionError("influences", f"it is at least 1, not {count}")
    if count is None or count >= weights.shape[1]:
        return weights
    kept = np.argsort(-weights, axis=1, kind="stable")[:, :count]
    found = np.zeros_like(weights)
    np.put_along_axis(found, kept, np.take_along_axis(weights, kept, axis=1), axis=1)
    return found


def parents_among(
    parents: Sequence[int] | Mapping[int, int], joints: Sequence[int]
) -> tuple[int, ...]:
    """Return the parents of some joints among these: the nearest ancestor of each that is there.

    Parameters
    ----------
    parents
        Number of the parent of each joint of a tree, -1 for none.
    joints
        Numbers of the joints.

    Returns
    -------
    Places in `joints`, -1 for none.
    """
    place = {joint: number for number, joint in enumerate(joints)}
    found = []
    for joint in joints:
        above = parents[joint]
        while above >= 0 and above not in place:
            above = parents[above]
        found.append(place.get(above, -1))
    return tuple(found)
