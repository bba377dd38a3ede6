"""Contracts of parameters: they take what the solver takes, and mean what the solver means."""

import math
from typing import Any

import pytest
from pydantic import BaseModel, ValidationError

from broker.contracts import (
    MESH_FORMATS,
    DissimilarityParameters,
    MatchParameters,
    PicturePayload,
    PrototypeParameters,
    file_type_of,
)
from solver.errors import OptionError
from solver.labelling import LINF
from solver.matching import MatchOptions
from solver.mesh import MESH_FORMATS as READ
from solver.parameters import ParameterSet
from solver.prototype import PrototypeOptions
from solver.shape.choices import Diffusion, Geodesic, HeatKernelSignature, NoDescriptor
from solver.similarity import SimilarityOptions
from worker.jobs.options import options_of

JOBS: list[tuple[type[BaseModel], type[ParameterSet]]] = [
    (MatchParameters, MatchOptions),
    (DissimilarityParameters, SimilarityOptions),
    (PrototypeParameters, PrototypeOptions),
]
RANGES = [
    (model, options, name)
    for model, options in JOBS
    for name, known in options.parameters().items()
    if known.most is not None
]


def test_the_formats_are_those_that_are_read() -> None:
    assert set(MESH_FORMATS) == set(READ)


@pytest.mark.parametrize(("model", "options"), JOBS)
def test_defaults(model: type[BaseModel], options: type[ParameterSet]) -> None:
    assert options_of(options, model()) == options()


@pytest.mark.parametrize(("model", "options", "name"), RANGES)
def test_ranges(model: type[BaseModel], options: type[ParameterSet], name: str) -> None:
    known = options.parameters()[name]
    assert known.most is not None
    whole = isinstance(known.default, int)
    below = (
        known.above
        if known.least is None
        else known.least - 1
        if whole
        else math.nextafter(known.least, -math.inf)
    )
    least = math.nextafter(known.above, math.inf) if known.above is not None else known.least
    above = known.most + 1 if whole else math.nextafter(known.most, math.inf)
    for value in (least, known.most):
        assert getattr(options_of(options, model.model_validate({name: value})), name) == value
    for value in (below, above, math.nan):
        values: dict[str, Any] = {name: value}
        with pytest.raises(ValidationError):
            model.model_validate(values)
        with pytest.raises(OptionError) as caught:
            options(**values)
        assert caught.value.field == name


@pytest.mark.parametrize(
    "values",
    [
        {"points": 33},
        {"points": 8, "occlusion_cost": 1.0},
        {"points": 8, "third_order": 0.1},
    ],
)
def test_the_linf_objective_excludes_other_options(values: dict[str, Any]) -> None:
    assert options_of(MatchOptions, MatchParameters(objective="linf", points=32)).objective == LINF
    with pytest.raises(ValidationError, match="linf"):
        MatchParameters(objective="linf", **values)
    with pytest.raises(OptionError, match="linf"):
        MatchOptions(objective="linf", **values)


def test_one_name_or_several() -> None:
    one = options_of(MatchOptions, MatchParameters(metric="geodesic", descriptor="none"))
    assert (one.metric, one.descriptor) == ((Geodesic(),), (NoDescriptor(),))
    several = MatchParameters.model_validate(
        {
            "metric": [{"name": "diffusion", "time": 2}, "diffusion"],
            "descriptor": [{"name": "hks", "times": [0.5, 1]}, "none"],
        }
    )
    assert options_of(MatchOptions, several).metric == (Diffusion(2.0), Diffusion())
    assert options_of(MatchOptions, several).descriptor == (
        HeatKernelSignature((0.5, 1.0)),
        NoDescriptor(),
    )


@pytest.mark.parametrize(
    ("metric", "descriptor", "needed"),
    [
        ("geodesic", "none", False),
        ("geodesic", "hks", True),
        ("diffusion", "none", True),
        (("geodesic", "commute_time"), "none", True),
        ("geodesic", ("none", "si_hks"), True),
    ],
)
def test_when_a_spectrum_is_needed(metric: object, descriptor: object, needed: bool) -> None:
    parameters = MatchParameters.model_validate(
        {"metric": metric, "descriptor": descriptor, "orientation": False}
    )
    assert parameters.needs_spectrum is needed
    assert options_of(MatchOptions, parameters).needs_spectrum is needed
    for change in ({"refine": "gmds"}, {"orientation": True}):
        extended = parameters.model_copy(update=change)
        assert extended.needs_spectrum
        assert options_of(MatchOptions, extended).needs_spectrum


def test_an_extension_has_eigenpairs_enough() -> None:
    """Orientation and refinement begin with a dense map, whose eigenpairs come from the cache."""
    for given, plain, refined in ((30, 30, 100), (100, 100, 100), (150, 150, 150)):
        assert MatchParameters(eigenpairs=given, orientation=False).spectrum_size == plain
        assert MatchParameters(eigenpairs=given).spectrum_size == refined
        refining = MatchParameters(eigenpairs=given, orientation=False, refine="gmds")
        assert refining.spectrum_size == refined


@pytest.mark.parametrize(("weight", "size"), [(0.5, 101), (0.0, 100)])
def test_descriptors_have_eigenpairs_enough(weight: float, size: int) -> None:
    """The constant eigenfunction is not counted."""
    descriptor: Any = {"name": "eigenfunctions", "count": 100}
    given: Any = {"descriptor": descriptor, "first_order_weight": weight}
    for parameters in MatchParameters(**given), DissimilarityParameters(**given):
        assert parameters.spectrum_size == size
    parameters = MatchParameters(**given)
    needed = options_of(MatchOptions, parameters).least_eigenpairs
    assert max(parameters.eigenpairs, needed) == size
    few = PrototypeParameters(descriptor=descriptor, eigenpairs=50)
    assert few.spectrum_size == 101


@pytest.mark.parametrize(
    ("filename", "file_type"),
    [
        ("a.off", "off"),
        ("A.OBJ", "obj"),
        ("dir.x/a.b.ply", "ply"),
        ("c:\\x\\y.stl", "stl"),
        ("a.doc", None),
        ("off", None),
        ("", None),
    ],
)
def test_file_types(filename: str, file_type: str | None) -> None:
    assert file_type_of(filename) == file_type


def test_integers_may_be_written_with_a_fraction_of_zero() -> None:
    found = MatchParameters.model_validate({"points": 8.0, "beta": 2.0, "landmarks": [[5.0, 7]]})
    assert found.landmarks == ((5, 7),)
    assert (found.points, type(found.points), found.beta) == (8, int, 2.0)
    for wrong in (8.5, "8", True, math.inf, math.nan):
        with pytest.raises(ValidationError):
            MatchParameters.model_validate({"points": wrong})


def test_a_picture_without_alternative_is_stored_once() -> None:
    default = PicturePayload(job="a")
    assert default.model_copy(update={"alternative": 0}).variant == default.variant == ""
    assert default.model_copy(update={"alternative": 2}).variant == "2"
