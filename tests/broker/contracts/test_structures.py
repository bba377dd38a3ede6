"""Contracts of structures take the values that the solver takes."""

import math
from typing import Any

import pytest
from pydantic import ValidationError

from broker.contracts import DESCRIPTORS, METRICS, Choice, MatchParameters
from solver.errors import OptionError
from solver.matching import MatchOptions
from solver.shape import choices as structures
from worker.jobs.options import options_of

KINDS: dict[str, tuple[type[structures.Structure], type[Choice]]] = {
    name: ((structures.METRICS.get(name) or structures.DESCRIPTORS[name]), kind)
    for name, kind in (METRICS | DESCRIPTORS).items()
}


def field_of(name: str) -> str:
    return "metric" if name in METRICS else "descriptor"


@pytest.mark.parametrize("name", KINDS)
def test_defaults_are_the_same(name: str) -> None:
    kind, model = KINDS[name]
    parameters = MatchParameters.model_validate({field_of(name): {"name": name}})
    assert getattr(options_of(MatchOptions, parameters), field_of(name)) == (kind(),)
    assert MatchParameters.model_validate({field_of(name): name}) != parameters
    plain = model.model_validate({"name": name}).model_dump(exclude={"name"})
    assert plain == {parameter: getattr(kind(), parameter) for parameter in kind.parameters()}


@pytest.mark.parametrize(
    ("name", "parameter"), [(name, p) for name in KINDS for p in KINDS[name][0].parameters()]
)
def test_both_take_the_same_values(name: str, parameter: str) -> None:
    kind, model = KINDS[name]
    known = kind.parameters()[parameter]
    assert known.least is not None
    assert known.most is not None
    whole = isinstance(known.default, int)
    below = known.least - 1 if whole else math.nextafter(known.least, -math.inf)
    above = known.most + 1 if whole else math.nextafter(known.most, math.inf)
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


def test_choices_survive_serialisation() -> None:
    asked = MatchParameters.model_validate(
        {"metric": [{"name": "diffusion", "time": 0.1 + 0.2}, "geodesic"], "normalise": False}
    )
    assert MatchParameters.model_validate_json(asked.model_dump_json()) == asked
    assert options_of(MatchOptions, asked).metric == (
        structures.Diffusion(0.1 + 0.2),
        structures.Geodesic(),
    )
