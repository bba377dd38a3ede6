"""Confidence in words: sure, or in doubt for these reasons."""

import json
from typing import Any

import isomatch
import pytest
from isomatch._cli.render import print_match, print_transfer
from rich.console import Console

from tests.client._models.test_schema import OPENAPI

EXAMPLE: dict[str, Any] = OPENAPI["paths"]["/v1/jobs/{job_id}/result"]["get"]["responses"]["200"][
    "content"
]["application/json"]["examples"]["match"]["value"]
DOUBT = {"probability": 0.31, "reasons": ["the mirror image fits nearly as well", "few points"]}
PHRASE = "in doubt, confidence 31 %: the mirror image fits nearly as well; few points"


def match(**changes: Any) -> isomatch.Match:
    return isomatch.Match.from_json(json.dumps(EXAMPLE | changes))


def printed(found: isomatch.Match) -> str:
    console = Console(width=160, no_color=True)
    with console.capture() as capture:
        print_match(found, console)
    return capture.get()


@pytest.mark.parametrize(
    ("probability", "phrase"),
    [
        (1.0, "confidence 99 %"),
        (0.97, "confidence 97 %"),
        (0.51, "confidence 51 %"),
        (0.5, "in doubt, confidence 50 %"),
        (0.49, "in doubt, confidence 49 %"),
        (0.0, "in doubt, confidence 1 %"),
    ],
)
def test_a_phrase_has_the_percentage(probability: float, phrase: str) -> None:
    assert str(isomatch.Confidence(probability=probability, reasons=())) == phrase


@pytest.mark.parametrize(
    ("confidence", "words"),
    [
        ({"probability": 0.97, "reasons": []}, "yes: no better correspondence among"),
        (DOUBT, "only among this answer's candidates: the answer itself is in doubt"),
    ],
)
def test_a_certificate_of_an_answer_in_doubt_says_so(
    confidence: dict[str, object], words: str
) -> None:
    lines = printed(match(confidence=confidence, certified=True)).splitlines()
    (line,) = [one for one in lines if one.startswith("certified ") and "levels" not in one]
    assert line.removeprefix("certified").strip().startswith(words)


def test_a_match_that_is_sure() -> None:
    found = match()
    assert found.confidence is not None
    assert (found.confidence.probability, found.confidence.reasons) == (0.97, ())
    assert not found.confidence.in_doubt
    assert ", confidence 97 %, energy 0.0145, certified among its candidates, " in repr(found)
    assert "sure, confidence 97 %" in printed(found)


def test_a_match_that_is_in_doubt_says_why() -> None:
    found = match(confidence=DOUBT)
    assert found.confidence is not None
    assert found.confidence.in_doubt
    assert PHRASE in repr(found)
    assert PHRASE in printed(found)
    assert "likely right" not in printed(found)


def test_a_match_that_was_not_registered_has_no_confidence() -> None:
    for found in (
        match(confidence=None),
        isomatch.Match.from_json(
            json.dumps({name: value for name, value in EXAMPLE.items() if name != "confidence"})
        ),
    ):
        assert found.confidence is None
        assert "confidence" not in repr(found) + printed(found)


def test_a_certificate_says_what_it_is_about() -> None:
    assert "no better correspondence among this answer's candidates" in printed(match())
    assert "see the gap" in printed(match(certified=False))


def test_less_energy_of_another_correspondence_is_explained() -> None:
    energy = EXAMPLE["energy"]
    other = {name: EXAMPLE[name] for name in ("correspondences", "distortion")}
    for factor, explained in ((0.5, True), (1.0, False)):
        changed = [other | {"energy": factor * energy, "relation": "mirror_image"}]
        for confidence, reason in (
            (EXAMPLE["confidence"], ""),
            (DOUBT, ", which is in doubt"),
            (None, ""),
        ):
            text = printed(match(alternatives=changed, proof=None, confidence=confidence))
            text = " ".join(text.split())
            said = "one alternative has less energy; registration in space chose this answer"
            assert (said + reason in text) is (explained and confidence is not None)


def test_a_transfer_says_that_its_match_is_in_doubt() -> None:
    carried = OPENAPI["paths"]["/v1/jobs/{job_id}/result"]["get"]["responses"]["200"]["content"]
    example = carried["application/json"]["examples"]["transfer"]["value"]
    for confidence, words in (
        (EXAMPLE["confidence"], "sure, confidence 97 %"),
        (DOUBT, PHRASE),
    ):
        found = isomatch.Transfer.from_json(json.dumps(example | {"confidence": confidence}))
        console = Console(width=160, no_color=True)
        with console.capture() as capture:
            print_transfer(found, console)
        assert " ".join(["answer", words]) in " ".join(capture.get().split())
