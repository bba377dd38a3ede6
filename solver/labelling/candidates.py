"""Candidates of the labelling problem that agree with landmarks."""

import numpy as np

from solver.arrays import BoolArray


def pairs_with_landmarks(sources: int, targets: int, landmarks: int) -> BoolArray:
    """(N, M) pairs of points that may be matched where the first L of both are landmarks.

    Parameters
    ----------
    sources, targets
        Numbers N and M of points.
    landmarks
        Number L of landmarks, each of which has the one of the same place as its only partner.
    """
    allowed = np.ones((sources, targets), dtype=np.bool_)
    allowed[:landmarks] = allowed[:, :landmarks] = False
    np.fill_diagonal(allowed[:landmarks, :landmarks], True)
    return allowed
