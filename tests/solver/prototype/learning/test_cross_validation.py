"""Misfit of a target, relative to left-out examples."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from solver.errors import PrototypeError
from solver.matching import Match, MatchOptions
from solver.mesh import triangle_mesh
from solver.prototype import (
    Example,
    Prototype,
    PrototypeOptions,
    connected_examples,
    learn_prototype,
    match_prototype,
    prototype_from_bytes,
    prototype_to_bytes,
)
from solver.shape import Shape
from synthetic import HUMAN_POSES, articulated, human

_OPTIONS = PrototypeOptions(points=8, components=2)


@cache
def examples() -> tuple[Example, ...]:
    """One body in five poses, triangulated alike."""
    figures = [human(pose, resolution=500) for pose in HUMAN_POSES]
    shapes = [Shape(triangle_mesh(one.vertices, one.faces)) for one in figures]
    return connected_examples(shapes, _OPTIONS).examples


@cache
def figure(category: str, pose: str, seed: int) -> Shape:
    made = articulated(category, pose, 500, seed)
    return Shape(triangle_mesh(made.vertices, made.faces))


@cache
def prototype() -> Prototype:
    return learn_prototype(examples(), _OPTIONS)


def matched(target: Shape, **options: float) -> Match:
    return match_prototype(prototype(), target, MatchOptions(**options))  # type: ignore[arg-type]


def plain(target: Shape, **options: float) -> Match:
    return matched(target, orientation=False, **options)


def unlike(answer: Match) -> bool:
    return any("unlike" in warning for warning in answer.warnings)


def test_misfit_separates_another_human_from_an_animal() -> None:
    usual, animal = matched(figure("human", "walking", 9)), plain(figure("cat", "standing", 0))
    assert usual.misfit is not None
    assert animal.misfit is not None
    limit = prototype().greatest_misfit
    assert usual.misfit < limit < animal.misfit
    assert unlike(animal)
    assert not unlike(usual)


def test_misfit_is_the_least_energy_per_point_over_the_usual_one() -> None:
    """Left-out examples have no surface that may prefer an answer of more energy."""
    answer = matched(figure("human", "sitting", 9))
    energies = prototype().left_out_energies
    assert len(energies) == len(examples())
    assert (np.diff(energies) >= 0.0).all()
    assert prototype().usual_energy == max(np.median(energies), 0.1)
    least = min(one.energy for one in answer.alternatives)
    assert answer.best.energy > least
    expected = least / 8 / prototype().usual_energy
    assert answer.misfit == pytest.approx(expected)


def test_the_order_of_the_examples_does_not_matter() -> None:
    first, *others = examples()
    turned = learn_prototype((first, *others[::-1]), _OPTIONS)
    expected = prototype().left_out_energies
    np.testing.assert_allclose(turned.left_out_energies, expected, rtol=1e-6)


def test_misfit_is_unknown_without_a_comparable_usual_energy() -> None:
    target = figure("human", "walking", 9)
    few = learn_prototype(examples()[:3], _OPTIONS)
    assert not len(few.left_out_energies)
    assert np.isnan(few.usual_energy)
    assert np.isnan(few.greatest_misfit)
    assert match_prototype(few, target, MatchOptions(orientation=False)).misfit is None
    others = {"beta": 2.0, "first_order_weight": 0.2, "occlusion_cost": 5.0, "oversampling": 3}
    for name, value in others.items():
        assert plain(target, **{name: value}).misfit is None
    assert plain(target, points=6).misfit is None


def test_misfit_is_unknown_where_the_least_energy_is_not_proven() -> None:
    hurried = plain(figure("human", "walking", 9), time_limit=1e-9)
    assert hurried.misfit is None
    assert not unlike(hurried)


def test_two_points_have_no_usual_energy() -> None:
    """A match takes three."""
    two = [Example(one.shape, one.vertices[:2]) for one in examples()]
    learned = learn_prototype(two, _OPTIONS)
    assert not len(learned.left_out_energies)
    assert match_prototype(learned, figure("human", "walking", 9)).misfit is None


def test_an_archive_holds_the_energies() -> None:
    again = prototype_from_bytes(prototype_to_bytes(prototype()))
    np.testing.assert_array_equal(again.left_out_energies, prototype().left_out_energies)
    old = replace(prototype(), left_out_energies=np.zeros(0))
    assert not len(prototype_from_bytes(prototype_to_bytes(old)).left_out_energies)
    for wrong in (np.array([2.0, 1.0]), np.array([-1.0, 1.0]), np.array([np.nan])):
        damaged = prototype_to_bytes(replace(prototype(), left_out_energies=wrong))
        with pytest.raises(PrototypeError, match="left_out_energies"):
            prototype_from_bytes(damaged)
