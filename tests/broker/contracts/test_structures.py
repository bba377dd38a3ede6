"""The catalogue says of every structure what the solver says, and takes what it takes."""

import math
from typing import Any

import pytest
from pydantic import ValidationError

from broker.contracts import DESCRIPTORS, METRICS, Choice, MatchParameters, Structure, catalogue
from solver.errors import OptionError
from solver.shape import choices as structures
from worker.jobs.matches import options_of

KINDS: dict[str, tuple[type[structures.Structure], type[Choice], Structure]] = {
    entry.name: (solver[entry.name], contracts[entry.name], entry)
    for solver, contracts, entries in (
        (dict(structures.METRICS), METRICS, catalogue().metrics),
        (dict(structures.DESCRIPTORS), DESCRIPTORS, catalogue().descriptors),
    )
    for entry in entries
}


def field_of(name: str) -> str:
    return "metric" if name in METRICS else "descriptor"


def test_all_are_listed() -> None:
    assert [entry.name for entry in catalogue().metrics] == list(structures.METRICS)
    assert [entry.name for entry in catalogue().descriptors] == list(structures.DESCRIPTORS)


@pytest.mark.parametrize("name", KINDS)
def test_what_is_said_of_a_structure(name: str) -> None:
    kind, _, entry = KINDS[name]
    ours = kind.invariance
    said = entry.invariance
    assert (said.bending, said.topology, said.scale) == (ours.bending, ours.topology, ours.scale)
    assert entry.spectral == kind.spectral
    assert entry.needs_colors == kind.colored
    assert entry.description.endswith(".")
    assert entry.formula
    known = kind.parameters()
    assert [parameter.name for parameter in entry.parameters] == list(known)
    for parameter in entry.parameters:
        limits = known[parameter.name]
        assert (parameter.minimum, parameter.maximum) == (limits.least, limits.most)
        assert parameter.unit == limits.unit
        assert parameter.type == (
            "numbers" if limits.longest else "integer" if limits.whole else "number"
        )
        assert parameter.default == pytest.approx(limits.default, rel=1e-12)


@pytest.mark.parametrize("name", KINDS)
def test_left_out_means_the_same(name: str) -> None:
    kind, model, _ = KINDS[name]
    parameters = MatchParameters.model_validate({field_of(name): {"name": name}})
    assert getattr(options_of(parameters), field_of(name)) == (kind(),)
    assert MatchParameters.model_validate({field_of(name): name}) != parameters
    plain = model.model_validate({"name": name}).model_dump(exclude={"name"})
    assert plain == {parameter: getattr(kind(), parameter) for parameter in kind.parameters()}


@pytest.mark.parametrize(
    ("name", "parameter"), [(name, p) for name in KINDS for p in KINDS[name][0].parameters()]
)
def test_both_take_the_same_values(name: str, parameter: str) -> None:
    kind, model, _ = KINDS[name]
    known = kind.parameters()[parameter]
    below = known.least - 1 if known.whole else math.nextafter(known.least, -math.inf)
    above = known.most + 1 if known.whole else math.nextafter(known.most, math.inf)
    right: list[Any] = [known.least, known.most]
    wrong: list[Any] = [below, above, math.nan]
    if known.longest:
        right, wrong = [[value] for value in right], [[value] for value in wrong]
        wrong += [[], [known.least] * (known.longest + 1)]
    for value in right:
        chosen = model.model_validate({"name": name, parameter: value})
        assert kind(**chosen.model_dump(exclude={"name"})) == kind(**{parameter: value})
    for value in wrong:
        with pytest.raises(ValidationError):
            model.model_validate({"name": name, parameter: value})
        with pytest.raises(OptionError) as caught:
            kind(**{parameter: value})
        assert caught.value.field == parameter


def test_choices_survive_the_journey() -> None:
    asked = MatchParameters.model_validate(
        {"metric": [{"name": "diffusion", "time": 0.1 + 0.2}, "geodesic"], "normalise": False}
    )
    assert MatchParameters.model_validate_json(asked.model_dump_json()) == asked
    assert options_of(asked).metric == (structures.Diffusion(0.1 + 0.2), structures.Geodesic())
