"""The transfer function of sRGB: display values, as in images, and linear light."""

import numpy as np

from solver.arrays import FloatArray

_KNEE, _SLOPE, _OFFSET, _EXPONENT = 0.04045, 12.92, 0.055, 2.4
"""Constants of sRGB, IEC 61966-2-1."""


def linear_light(values: FloatArray) -> FloatArray:
    """Convert display values to linear light, both in 0..1."""
    light: FloatArray = np.where(
        values <= _KNEE, values / _SLOPE, ((values + _OFFSET) / (1.0 + _OFFSET)) ** _EXPONENT
    )
    return light


def display_values(light: FloatArray) -> FloatArray:
    """Convert linear light to display values: the inverse of :func:`linear_light`."""
    bright = (1.0 + _OFFSET) * np.maximum(light, 0.0) ** (1.0 / _EXPONENT) - _OFFSET
    values: FloatArray = np.where(light <= _KNEE / _SLOPE, light * _SLOPE, bright)
    return values


def tinted(values: FloatArray, light: FloatArray) -> FloatArray:
    """Multiply display values by factors of linear light.

    Parameters
    ----------
    values
        (..., 3) in 0..1.
    light
        (3,), or broadcastable to `values`: factors in 0..1.

    Returns
    -------
    (..., 3) in 0..1; exactly `values` where all factors are 1.
    """
    if (light == 1.0).all():
        return values
    changed = display_values(linear_light(values) * light)
    result: FloatArray = np.where(light == 1.0, values, changed)
    return result
