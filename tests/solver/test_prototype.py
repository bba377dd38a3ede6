"""Prototypes: learnt from examples, stored, and matched."""

from functools import cache

import pytest

from solver.errors import OptionError
from solver.mesh import triangle_mesh
from solver.options import MatchOptions
from solver.prototype import (
    Prototype,
    PrototypeOptions,
    connected_examples,
    learn_prototype,
    match_prototype,
    prototype_from_bytes,
    prototype_to_bytes,
)
from solver.shape import Shape
from solver.synthetic import HUMAN_POSES, human

_RESOLUTION = 500


@cache
def humans() -> tuple[Shape, ...]:
    """One body in several poses, triangulated alike."""
    figures = [human(pose, resolution=_RESOLUTION) for pose in HUMAN_POSES]
    return tuple(Shape(triangle_mesh(one.vertices, one.faces)) for one in figures)


@cache
def prototype() -> Prototype:
    options = PrototypeOptions(points=8, components=2)
    return learn_prototype(connected_examples(humans(), options).examples, options)


def test_a_prototype_finds_its_own_points_on_an_example() -> None:
    target = humans()[1]
    answer = match_prototype(prototype(), target, MatchOptions(points=8))
    assert answer.best.source.tolist() == list(range(8))
    assert answer.certified
    assert 0.0 <= answer.lower_bound <= answer.best.energy


def test_an_archive_holds_all_of_a_prototype() -> None:
    data = prototype_to_bytes(prototype())
    again = prototype_from_bytes(data)
    assert prototype_to_bytes(again) == data


def test_options_that_mean_nothing_for_a_prototype_are_refused() -> None:
    with pytest.raises(OptionError) as caught:
        match_prototype(prototype(), humans()[0], MatchOptions(refine="gmds"))
    assert caught.value.field == "refine"
