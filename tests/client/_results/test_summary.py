"""Results of several shapes as text: one screen, with names beside ids."""

import io
from itertools import combinations
from typing import Any

from isomatch import Batch, ConsistentMaps, Registration
from isomatch._cli.maps_rendering import print_maps
from rich.console import Console

IDS = [f"{place:02x}" * 16 for place in range(16)]
SURE = {"probability": 0.97, "reasons": []}
LONG = "x" * 200


def specimen(place: int, **changes: Any) -> dict[str, Any]:
    return {
        "shape": IDS[place], "name": f"s{place}.ply", "registered": True, "reason": None,
        "confidence": SURE, "mean_distance": 0.001, "max_distance": 0.0123, "flipped": 4,
        "reflected": False, "scores": [], **changes,
    }  # fmt: skip


def pair(i: int, j: int, **changes: Any) -> dict[str, Any]:
    return {
        "source": IDS[i], "source_name": None, "target": IDS[j], "target_name": None,
        "mapped": True, "confidence_before": SURE, "confidence": SURE, "cycle_error_before": 0.25,
        "cycle_error": 0.25, "through": [], "fits": True, "reason": None, **changes,
    }  # fmt: skip


def shape(place: int, **changes: Any) -> dict[str, Any]:
    return {
        "shape": IDS[place], "name": f"s{place}.ply", "cycle_error_before": 0.25,
        "cycle_error": 0.25, "fits": True, "reason": None, **changes,
    }  # fmt: skip


def registration(*specimens: dict[str, Any]) -> Registration:
    return Registration.model_validate(
        {
            "template": IDS[0],
            "template_name": LONG,
            "vertices": 7,
            "scale": False,
            "specimens": specimens,
            "warnings": [],
            "timings": {},
            "components": [{"variance": 2.0, "explained": 0.75}],
        }
    )


def test_a_registration_names_its_specimens() -> None:
    flat = specimen(2, registered=False, reason="it is flat", name=None)
    result = registration(specimen(1), flat)
    heading, first, second = str(result).splitlines()
    assert heading.startswith("xxx")
    assert heading.endswith("x… registered to 1 of 2 specimens; variance of the components: 75 %")
    assert first == "  s1.ply: distance at most 0.012, 4 flipped triangles, confidence 97 %"
    assert second == f"  {IDS[2]}: not registered: it is flat"
    assert repr(result) == "<Registration of 1 of 2 specimens>"


def test_shapes_of_one_name_have_their_ids() -> None:
    twice = specimen(2, name="s1.ply", registered=False, reason="it is flat")
    _, first, second = str(registration(specimen(1), twice)).splitlines()
    assert first.startswith(f"  s1.ply ({IDS[1]}): distance")
    assert second == f"  s1.ply ({IDS[2]}): not registered: it is flat"


def test_maps_of_a_large_collection_fit_a_screen_and_begin_with_what_does_not_fit() -> None:
    changes: dict[tuple[int, int], dict[str, Any]] = {
        (3, 9): {"through": [IDS[5]], "cycle_error": 0.125},
        (4, 8): {"fits": False, "reason": "it is probably wrong"},
        (14, 15): {"mapped": False, "confidence": None, "cycle_error": None, "fits": False,
                   "reason": "no time"},
    }  # fmt: skip
    result = ConsistentMaps.model_validate(
        {
            "shapes": [*(shape(place) for place in range(15)), shape(15, fits=False, reason="odd")],
            "pairs": [pair(i, j, **changes.get((i, j), {})) for i, j in combinations(range(16), 2)],
            "cycle_error_before": 0.25,
            "cycle_error": 0.125,
            "warnings": [],
            "timings": {},
        }
    )
    heading, *lines = str(result).splitlines()
    assert heading == "119 of 120 pairs of 16 shapes mapped; mean cycle error 0.25 -> 0.125"
    assert len(lines) == 21
    assert lines[0] == "  s15.ply: does not fit: odd"
    assert lines[1].endswith(
        ": confidence 97 %; cycle error 0.25; does not fit: it is probably wrong"
    )
    assert lines[2].endswith("s14.ply - s15.ply: no map; does not fit: no time")
    assert lines[3].endswith("cycle error 0.25 -> 0.125; through s5.ply")
    assert lines[-1] == "  and 101 more"


def test_a_shape_that_no_pair_fits_does_not_fit() -> None:
    doubtful = {"fits": False, "reason": "it is probably wrong"}
    result = ConsistentMaps.model_validate(
        {
            "shapes": [shape(place) for place in range(3)],
            "pairs": [pair(0, 1), pair(0, 2, **doubtful), pair(1, 2, **doubtful)],
            "cycle_error_before": 0.05,
            "cycle_error": 0.05,
            "warnings": [],
            "timings": {},
        }
    )
    assert str(result).splitlines()[1] == "  s2.ply: does not fit: none of its pairs does"
    console = Console(width=120, record=True, file=io.StringIO())
    print_maps(result, console)
    rows = [line.split() for line in console.export_text().splitlines()]
    assert [row[-1] for row in rows if row[:2] == ["s1.ply", "s2.ply"]] == ["no"]
    assert [row[-1] for row in rows if row[:2] == ["s0.ply", "s1.ply"]] == ["yes"]
    said = {row[0]: " ".join(row[3:]) for row in rows if len(row) > 1 and row[1] in IDS}
    assert said == {
        "s0.ply": "fits in 1 of 2 pairs",
        "s1.ply": "fits in 1 of 2 pairs",
        "s2.ply": "does not fit: none of its pairs does",
    }


def test_a_batch_names_its_targets() -> None:
    match = {"target": IDS[1], "target_name": "b.off", "job": "1", "fraction": 1.0, "error": None}
    distortion = {"first_order": None, "second_order": 0.5, "linf": 1.0}
    summary = {
        "confidence": SURE, "distortion": distortion, "energy": 1.0, "certified": True,
        "dense": False,
    }  # fmt: skip
    error = {"type": "/problems/shape-deleted", "title": "Shape deleted", "status": 410,
             "detail": "it was deleted"}  # fmt: skip
    result = Batch.model_validate(
        {
            "source": IDS[0],
            "source_name": "a.off",
            "parameters": {},
            "matches": [
                {**match, "state": "succeeded", "summary": summary},
                {**match, "state": "failed", "summary": None, "error": error},
                {**match, "state": "cancelled", "summary": None},
            ],
            "succeeded": 1,
            "warnings": [],
            "timings": {},
        }
    )
    heading, done, failed, cancelled = str(result).splitlines()
    assert heading == "a.off matched with 1 of 3 targets"
    target = "  b.off"
    assert done == f"{target}: succeeded, second-order distortion 0.5, confidence 97 %"
    assert failed.startswith(f"{target}: failed: ")
    assert "it was deleted" in failed
    assert cancelled == f"{target}: cancelled"
