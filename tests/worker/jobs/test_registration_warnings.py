"""Warnings of registrations: which specimens are named, and which are not."""

from dataclasses import replace

from solver.mesh import triangle_mesh
from tests.worker.figures import blob
from worker.jobs.registration_warnings import (
    doubtful_specimens,
    named_warnings,
    parts_as_wholes,
    unlike_sizes,
)

NAMES = ["a", "b", "c"]


def test_matches_in_doubt_are_named_with_their_confidence() -> None:
    (said,) = doubtful_specimens(NAMES, [0.9, 0.5, None], [0.0, 0.0, 0.0], 0.0)
    assert "'b' (0.50)" in said
    assert "'a'" not in said
    assert "'c'" not in said
    assert doubtful_specimens(NAMES, [0.51, 1.0, None], [0.0, 0.0, 0.0], 0.0) == ()


def test_parts_have_more_boundary_than_the_template() -> None:
    boundaries = [0.2, 2.5, 3.1]
    (said,) = doubtful_specimens(NAMES, [0.9] * 3, boundaries, 0.0)
    assert "'b' (2.5 √area), 'c' (3.1 √area)" in said
    assert "'a'" not in said
    (said,) = doubtful_specimens(NAMES, [0.9] * 3, boundaries, 2.0)
    assert "'c'" in said
    assert "'b'" not in said


def test_warnings_of_single_shapes_are_said_once() -> None:
    said = named_warnings([("a", ["linked", "linked"]), ("b", []), ("c", ["mirrored", "linked"])])
    assert said == ("a, c: linked", "c: mirrored")


def test_warnings_of_many_shapes_are_bounded() -> None:
    (said,) = named_warnings((f"{place}", ["linked"]) for place in range(256))
    assert said.endswith(", 19 and 236 more: linked")
    *_, last = found = named_warnings((f"{place}", [f"{place} links"]) for place in range(256))
    assert len(found) == 21
    assert last.startswith("236 more warnings")


def test_sizes_of_different_units_are_named() -> None:
    (said,) = unlike_sizes(NAMES, [2.0, 1800.0, 1.9])
    assert "'b' is 947 times as large as 'c'" in said
    assert unlike_sizes(NAMES, [2.0, 19.0, 1.9]) == ()
    assert unlike_sizes(NAMES[:1], [2.0]) == ()


def test_a_half_that_is_matched_as_a_whole_is_named() -> None:
    vertices, faces = blob(3)
    whole = triangle_mesh(vertices, faces)
    half = triangle_mesh(vertices, faces[vertices[faces, 1].max(axis=1) < vertices[:, 1].mean()])
    (said,) = parts_as_wholes(whole, half)
    assert "'target' (" in said
    assert "'source'" not in said
    (said,) = parts_as_wholes(half, whole)
    assert "'source' (" in said
    (said,) = parts_as_wholes(half, half)
    assert "'source' (" in said
    assert "'target' (" in said
    assert parts_as_wholes(whole, whole) == ()
    assert parts_as_wholes(whole, replace(half, is_cloud=True)) == ()
