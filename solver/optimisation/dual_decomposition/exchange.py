"""Exchange of cost shares between two subproblems, by the subgradient method with momentum."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.kernel import kernel

_MOMENTUM = 0.9
"""Share of the previous direction that is kept (heavy ball, Polyak 1964); a customary value."""
_LEAST_FACTOR = 1e-30
"""Common factor of a direction below which it is multiplied into the entries."""


class Used(NamedTuple):
    """Costs that the minimiser of a subproblem uses: a subgradient of its minimum.

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
    """Return positions whose costs are used with factor 1."""
    return Used(positions, np.ones(len(positions)))


class Exchange:
    """Shares of costs that two subproblems have in common, and the direction in which they move.

    An amount that is added to one share is subtracted from the other, so that the shares of a cost
    always add up to it: the projection of the projected subgradient, by construction. The direction
    is that of the heavy ball: the present subgradient and, fading, the earlier ones.

    Parameters
    ----------
    to
        (S,) costs of the subproblem that receives shares; changed in place.
    origin
        Costs of the subproblem that gives them; changed in place.
    index
        (S,) position in `origin` of each cost of `to`; negative for costs that `origin` does not
        have and that no minimiser uses.
    gains, losses
        Functions that return the costs which the present minimisers of the receiving and of the
        giving subproblem use, both as positions in `to`; negative positions are ignored.
    """

    def __init__(
        self,
        to: FloatArray,
        origin: FloatArray,
        index: IntArray,
        gains: Callable[[], Used],
        losses: Callable[[], Used],
    ) -> None:
        self._to, self._origin, self._index = to, origin, index
        self._gains, self._losses = gains, losses
        self._direction = _Direction(
            np.zeros(len(to)),
            np.zeros(len(to), dtype=np.bool_),
            np.zeros(len(to), dtype=np.int64),
            np.array([0.0, 1.0, 0.0]),
        )

    def update_direction(self) -> float:
        """Add the present subgradient; return the squared Euclidean norm of the new direction."""
        return _update(self._direction, *self._gains(), *self._losses(), _MOMENTUM)

    def step(self, length: float) -> None:
        """Move shares by `length` times the direction."""
        _step(self._direction, length, self._to, self._origin, self._index)


class _Direction(NamedTuple):
    """A sparse vector, `factor` times `values`.

    Fading only changes the factor, and the norm is kept up to date entry by entry, so that an
    update takes time in proportion to the entries that change.
    """

    values: FloatArray
    touched: BoolArray
    active: IntArray
    state: FloatArray  # number of active entries, factor, squared norm of the values


_COUNT, _FACTOR, _NORM = 0, 1, 2


@kernel
def _update(
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
        _apply_factor(direction)
    _add(direction, gains, gain_amounts, 1.0)
    _add(direction, losses, loss_amounts, -1.0)
    norm: float = state[_FACTOR] ** 2 * max(state[_NORM], 0.0)
    return norm


@kernel
def _apply_factor(direction: _Direction) -> None:
    """Multiply the factor into the values; compute the norm anew, without rounding errors."""
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
