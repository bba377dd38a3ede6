"""Shares of the costs, and the exchanges by which they move from one subproblem to another."""

from typing import NamedTuple

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.kernel import kernel


class Used(NamedTuple):
    """What a minimiser uses of a subproblem's costs.

    Attributes
    ----------
    positions
        (k,) positions among the costs.
    amounts
        (k,) how much of each: 1, or a half where the subproblem is relaxed.
    """

    positions: IntArray
    amounts: FloatArray


def used_once(positions: IntArray) -> Used:
    """Return positions that are used wholly."""
    return Used(positions, np.ones(len(positions)))


class _Direction(NamedTuple):
    """A vector of which few entries were ever touched: `factor` times `values`.

    What fades fades with the factor, and the norm is kept up as entries change, so that turning
    takes no longer than there are entries to change.
    """

    values: FloatArray
    touched: BoolArray
    active: IntArray
    state: FloatArray  # number of active entries, factor, squared norm of the values


class Exchange:
    """Costs that one subproblem has of another's, and the direction in which they move.

    Whatever is added to a share is taken from where it came from, so that all shares of a cost
    always add up to it: the projection of the projected subgradient, by construction. The
    direction is the heavy ball's: earlier subgradients, fading, and the present one.

    Parameters
    ----------
    to
        (S,) costs of the subproblem that gets shares; changed in place.
    origin
        Costs of the subproblem they are taken from; changed in place.
    index
        (S,) position in `origin` of each cost of `to`, negative for costs that `origin` has not
        and that no minimiser uses.
    """

    def __init__(self, to: FloatArray, origin: FloatArray, index: IntArray) -> None:
        self._to, self._origin, self._index = to, origin, index
        self._direction = _Direction(
            np.zeros(len(to)),
            np.zeros(len(to), dtype=np.bool_),
            np.zeros(len(to), dtype=np.int64),
            np.array([0.0, 1.0, 0.0]),
        )

    def turn(self, gains: Used, losses: Used, momentum: float) -> float:
        """Turn the direction towards the present subgradient.

        Parameters
        ----------
        gains, losses
            What the minimisers of the two subproblems use, both as positions in `to`; negative
            ones do not count.
        momentum
            What is kept of the direction so far, in (0, 1).

        Returns
        -------
        Squared Euclidean norm of the new direction.
        """
        return _turn(self._direction, *gains, *losses, momentum)

    def step(self, length: float) -> None:
        """Move costs by `length` times the direction."""
        _step(self._direction, length, self._to, self._origin, self._index)


_COUNT, _FACTOR, _NORM = 0, 1, 2
_LEAST_FACTOR = 1e-30


@kernel
def _turn(
    direction: _Direction,
    gains: IntArray,
    gain_amounts: FloatArray,
    losses: IntArray,
    loss_amounts: FloatArray,
    momentum: float,
) -> float:
    state = direction.state
    state[_FACTOR] *= momentum
    if state[_FACTOR] < _LEAST_FACTOR:
        _renew(direction)
    _add(direction, gains, gain_amounts, 1.0)
    _add(direction, losses, loss_amounts, -1.0)
    norm: float = state[_FACTOR] ** 2 * max(state[_NORM], 0.0)
    return norm


@kernel
def _renew(direction: _Direction) -> None:
    """Put the factor into the values, and rounding errors out of the norm."""
    values, active, state = direction.values, direction.active, direction.state
    norm = 0.0
    for k in range(int(state[_COUNT])):
        values[active[k]] *= state[_FACTOR]
        norm += values[active[k]] ** 2
    state[_FACTOR], state[_NORM] = 1.0, norm


@kernel
def _add(direction: _Direction, positions: IntArray, amounts: FloatArray, sign: float) -> None:
    values, touched, active = direction.values, direction.touched, direction.active
    state = direction.state
    count, norm = int(state[_COUNT]), state[_NORM]
    for k in range(len(positions)):
        position = positions[k]
        if position < 0:
            continue
        if not touched[position]:
            touched[position] = True
            active[count] = position
            count += 1
        change = sign * amounts[k] / state[_FACTOR]
        norm += change * (2.0 * values[position] + change)
        values[position] += change
    state[_COUNT], state[_NORM] = count, norm


@kernel
def _step(
    direction: _Direction, length: float, to: FloatArray, origin: FloatArray, index: IntArray
) -> None:
    values, active, state = direction.values, direction.active, direction.state
    count = int(state[_COUNT])
    length *= state[_FACTOR]
    if 4 * count > len(values):  # going through memory in order is faster than by the list
        for position in range(len(values)):
            change = length * values[position]
            to[position] += change
            if index[position] >= 0:
                origin[index[position]] -= change
        return
    for k in range(count):
        position = active[k]
        change = length * values[position]
        to[position] += change
        if index[position] >= 0:
            origin[index[position]] -= change
