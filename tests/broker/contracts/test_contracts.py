"""The contracts say what the solver says: names, defaults and ranges are the same on both sides."""

from dataclasses import fields
from typing import Any, get_args

import pytest
from pydantic import ValidationError

from broker.contracts import (
    DENSE_EIGENPAIRS,
    MESH_FORMATS,
    DescriptorName,
    GeodesicMethod,
    MatchParameters,
    MetricName,
    ObjectiveName,
    RefinementName,
    file_type_of,
)
from solver.errors import OptionError
from solver.functional_maps import EIGENPAIRS
from solver.labelling import L2, LINF
from solver.matching import GMDS, MatchOptions
from solver.mesh import MESH_FORMATS as READ
from solver.shape.choices import (
    DESCRIPTORS,
    METRICS,
    Diffusion,
    Geodesic,
    HeatKernelSignature,
    NoDescriptor,
)
from solver.shape.geodesics import DEFAULT_GEODESIC_METHOD, GEODESIC_METHODS
from worker.jobs.matches import options_of

NOT_FOR_THE_SOLVER = {"eigenpairs", "geodesic_method", "largest_component", "normalise", "simplify"}
"""Parameters that say how shapes are made."""


def test_names() -> None:
    assert set(get_args(MetricName)) == set(METRICS)
    assert set(get_args(DescriptorName)) == set(DESCRIPTORS)
    assert set(get_args(ObjectiveName)) == {L2, LINF}
    assert set(get_args(RefinementName)) == {GMDS}
    assert set(get_args(GeodesicMethod)) == set(GEODESIC_METHODS)
    assert MatchParameters().geodesic_method == DEFAULT_GEODESIC_METHOD
    assert set(MESH_FORMATS) == set(READ)
    options = {field.name for field in fields(MatchOptions)}
    assert set(MatchParameters.model_fields) == options | NOT_FOR_THE_SOLVER


def test_defaults() -> None:
    assert options_of(MatchParameters()) == MatchOptions()


RANGES = {
    "points": (3, 256),
    "coarse_points": (3, 10),
    "level_factor": (2, 4),
    "oversampling": (1, 8),
    "rho": (1.001, 4.0),
    "beta": (0.0, 1e6),
    "first_order_weight": (0.0, 1e6),
    "alternatives": (1, 32),
}


@pytest.mark.parametrize("name", RANGES)
def test_ranges(name: str) -> None:
    least, most = RANGES[name]
    for value in (least, most):
        parameters = MatchParameters.model_validate({name: value})
        assert getattr(options_of(parameters), name) == value
    for value in (least - 1, most + 1):
        values: dict[str, Any] = {name: value}
        with pytest.raises(ValidationError):
            MatchParameters.model_validate(values)
        with pytest.raises(OptionError):
            MatchOptions(**values)


@pytest.mark.parametrize("values", [{"points": 11}, {"points": 8, "occlusion_cost": 1.0}])
def test_what_the_minimax_objective_does_not_take(values: dict[str, Any]) -> None:
    assert options_of(MatchParameters(objective="linf", points=10)).objective == LINF
    with pytest.raises(ValidationError, match="linf"):
        MatchParameters(objective="linf", **values)
    with pytest.raises(OptionError, match="linf"):
        MatchOptions(objective="linf", **values)


def test_one_name_or_several() -> None:
    one = options_of(MatchParameters(metric="geodesic", descriptor="none"))
    assert (one.metric, one.descriptor) == ((Geodesic(),), (NoDescriptor(),))
    several = MatchParameters.model_validate(
        {
            "metric": [{"name": "diffusion", "time": 2}, "diffusion"],
            "descriptor": [{"name": "hks", "times": [0.5, 1]}, "none"],
        }
    )
    assert options_of(several).metric == (Diffusion(2.0), Diffusion())
    assert options_of(several).descriptor == (HeatKernelSignature((0.5, 1.0)), NoDescriptor())


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
    parameters = MatchParameters.model_validate({"metric": metric, "descriptor": descriptor})
    assert parameters.needs_spectrum is needed
    assert options_of(parameters).needs_spectrum is needed
    refined = parameters.model_copy(update={"refine": "gmds"})
    assert refined.needs_spectrum
    assert options_of(refined).needs_spectrum


def test_a_refinement_has_eigenpairs_enough() -> None:
    """Those of the dense map it begins with, so that none are computed beside the cache."""
    assert DENSE_EIGENPAIRS == EIGENPAIRS
    for given, plain, refined in ((30, 30, 100), (100, 100, 100), (150, 150, 150)):
        assert MatchParameters(eigenpairs=given).spectrum_size == plain
        assert MatchParameters(eigenpairs=given, refine="gmds").spectrum_size == refined


@pytest.mark.parametrize(
    ("filename", "file_type"),
    [
        ("a.off", "off"),
        ("A.OBJ", "obj"),
        ("dir.x/a.b.ply", "ply"),
        ("c:\\x\\y.stl", "stl"),
        ("a.txt", None),
        ("off", None),
        ("", None),
    ],
)
def test_file_types(filename: str, file_type: str | None) -> None:
    assert file_type_of(filename) == file_type
