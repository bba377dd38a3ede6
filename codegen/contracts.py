"""Contracts (pydantic models) of the solver's structures and options."""

import inspect
import re
import types
import typing
from typing import Any, Final

from codegen.python_source import docstring, header, literal
from solver.matching import MatchOptions
from solver.parameters import Parameter, ParameterSet
from solver.prototype import PrototypeOptions, PrototypeStructures
from solver.registration import EIGENPAIRS
from solver.shape import Shape
from solver.shape.choices import (
    DESCRIPTORS,
    GREATEST,
    METRICS,
    DescriptorChoice,
    MetricChoice,
    Structure,
)
from solver.shape.geodesics import GEODESIC_METHODS
from solver.similarity import SimilarityOptions

OPTIONS: Final = (MatchOptions, SimilarityOptions, PrototypeStructures, PrototypeOptions)

_TYPES: Final[dict[Any, str]] = {
    int: "int",
    float: "float",
    bool: "bool",
    tuple[float, ...]: "tuple[float, ...]",
    tuple[tuple[int, int], ...]: "tuple[Landmark, ...]",
    MetricChoice | str: "Metric",
    DescriptorChoice | str: "Descriptor",
    tuple[MetricChoice | str, ...]: "MetricByLevel",
    tuple[DescriptorChoice | str, ...]: "DescriptorByLevel",
}
"""Types of the solver's options, and those of the contracts."""

_NOTES: Final = {
    "Metric": "The name of a metric, or an object of its name and its parameters; `GET"
    " /v1/structures` lists them.",
    "MetricByLevel": "One metric for all levels, or one for each from the coarsest on, of which the"
    " last is repeated. A metric is its name, or an object of its name and its parameters; `GET"
    " /v1/structures` lists them.",
}
_LIKE_METRIC: Final = "Given like `metric`."

_EXAMPLES: Final[dict[str, list[Any]]] = {
    "Metric": ["geodesic", {"name": "diffusion", "time": 0.02}],
    "MetricByLevel": [
        "geodesic",
        {"name": "diffusion", "time": 0.02},
        ["commute_time", "geodesic"],
    ],
    "Descriptor": ["hks", {"name": "si_hks", "frequencies": 8}],
    "DescriptorByLevel": ["none", {"name": "si_hks", "frequencies": 8}, ["si_hks", "hks"]],
    "tuple[Landmark, ...]": [[[17, 203], [1040, 88]]],
}


def structure_choices() -> str:
    """Return the module with a model of each structure that can be chosen."""
    parts = [
        header("Models of the structures that can be chosen."),
        _STRUCTURE_IMPORTS.rstrip(),
        f"MetricName: TypeAlias = Literal[{', '.join(map(repr, METRICS))}]",
        f"DescriptorName: TypeAlias = Literal[{', '.join(map(repr, DESCRIPTORS))}]",
    ]
    for word, kinds in (("Metric", METRICS), ("Descriptor", DESCRIPTORS)):
        parts += [_choice(kind) for kind in kinds.values()]
        parts.append(_union(word, kinds))
    return "\n\n".join(parts) + "\n"


def solver_options() -> str:
    """Return the module with a model of each set of options, and constants of the solver."""
    shape = inspect.signature(Shape).parameters
    constants = {
        "GREATEST": (GREATEST, "Bound of lengths and areas, and of their inverses."),
        "REGISTRATION_EIGENPAIRS": (EIGENPAIRS, "Eigenpairs that surfaces are registered with."),
        "DEFAULT_EIGENPAIRS": (shape["eigenpairs"].default, "Eigenpairs of a shape's structures."),
        "DEFAULT_GEODESIC_METHOD": (shape["geodesic_method"].default, "Name of the method."),
    }
    parts = [header("Models of the solver's options, and its constants."), _OPTION_IMPORTS.rstrip()]
    parts += [f"{name}: Final = {v!r}\n{docstring(text)}" for name, (v, text) in constants.items()]
    names = ", ".join(map(repr, GEODESIC_METHODS))
    parts.append(f"GeodesicMethodName: TypeAlias = Literal[{names}]")
    parts += map(_options, OPTIONS)
    return "\n\n".join(parts) + "\n"


def description(known: Parameter) -> str:
    """Return the description of a parameter: the summary with its source, then details."""
    if not known.source:
        return known.meaning
    summary, *details = re.split(r"(?<=\.) ", known.meaning, maxsplit=1)
    return " ".join([f"{summary[:-1]} ({known.source}).", *details])


def _options(options: type[ParameterSet]) -> str:
    parent = options.__base__
    assert parent is not None
    base = "StrictModel" if parent is ParameterSet else parent.__name__
    body = [docstring((options.__doc__ or "").split("\n\n")[0])]
    body += [_option(options, name) for name in options.__annotations__]
    return "\n".join([f"class {options.__name__}({base}):", *_indented(body)])


def _option(options: type[ParameterSet], name: str) -> str:
    known = options.parameters()[name]
    written, optional = _annotation(options, name)
    text = description(known)
    if "Metric" in written or "Descriptor" in written:
        text = f"{text} {_NOTES[written] if name == 'metric' else _LIKE_METRIC}"
    arguments = [f"default={_default(known.default)}", *_limits(known)]
    arguments.append(f"description={literal(text)}")
    if written in _EXAMPLES:
        arguments.append(f"examples={_EXAMPLES[written]!r}")
    written = _listed(written, known)
    if optional:
        written += " | None"
    return f"{name}: Annotated[{written}, Topic({known.topic!r})] = Field({', '.join(arguments)})"


def _choice(kind: type[Structure]) -> str:
    name = f"{kind.__name__}Metric" if issubclass(kind, MetricChoice) else kind.__name__
    text = docstring(kind.__doc__ or "")
    rows = kind.invariance
    about = [
        f"name={kind.name!r}",
        f"description={literal(' '.join((kind.__doc__ or '').split()))}",
        f"formula={literal(kind.formula)}",
        f"source={literal(kind.source)}",
        f"unit={kind.value_unit!r}",
        f"invariance=Invariance(bending={rows.bending!r}, topology={rows.topology!r},"
        f" scale={rows.scale!r})",
        f"remarks={literal(kind.remarks)}",
        f"spectral={kind.spectral!r}",
        f"needs_colors={kind.colored!r}",
        f"parameters=({''.join(_catalogued(kind, one) + ',' for one in kind.parameters())})",
    ]
    body = [
        text,
        f"about = Structure({', '.join(about)})",
        f"name: Literal[{kind.name!r}] = Field(description='Name of the structure.')",
    ]
    body += [_structure_parameter(kind, one) for one in kind.parameters()]
    return "\n".join([f"class {name}(Choice):", *_indented(body)])


def _catalogued(kind: type[Structure], name: str) -> str:
    known = kind.parameters()[name]
    written, _ = _annotation(kind, name)
    types_of = {"int": "integer", "float": "number", "tuple[float, ...]": "numbers"}
    return (
        f"StructureParameter(name={name!r}, description={literal(_with_default(known))},"
        f" type={types_of[written]!r}, default={known.default!r},"
        f" minimum={known.least!r}, maximum={known.most!r}, unit={known.unit or '1'!r})"
    )


def _structure_parameter(kind: type[Structure], name: str) -> str:
    known = kind.parameters()[name]
    written, optional = _annotation(kind, name)
    limits = _limits(known)
    if known.longest:
        item = ", ".join(_range(known))
        written = _listed(f"tuple[Annotated[float, Field({item})], ...]", known)
    default = "None" if known.scales else repr(known.default)
    arguments = [f"default={default}", *limits, f"description={literal(_with_default(known))}"]
    return f"{name}: {written}{' | None' if optional else ''} = Field({', '.join(arguments)})"


def _with_default(known: Parameter) -> str:
    """Description of a structure's parameter, with its unit and the default on any surface."""
    if not known.scales:
        return known.meaning
    unit, whole = {
        "length": ("the shapes' unit of length", "√area"),
        "area": ("the square of the shapes' unit of length", "their area"),
    }[known.unit]
    value = known.default
    if known.longest:
        value = f"{len(value)} values from {value[0]:.2g} to {value[-1]:.2g}"
    return f"{known.meaning} In {unit}; null for {value} times {whole}."


def _annotation(owner: type[ParameterSet], name: str) -> tuple[str, bool]:
    """Type in the contract, and whether it may be null."""
    known = owner.parameters()[name]
    hint = typing.get_type_hints(owner)[name]
    if isinstance(hint, types.UnionType) and types.NoneType in typing.get_args(hint):
        (hint,) = (one for one in typing.get_args(hint) if one is not types.NoneType)
    if known.one_of:
        return f"Literal[{', '.join(map(repr, known.one_of))}]", known.optional
    return _TYPES[hint], known.optional


def _listed(written: str, known: Parameter) -> str:
    """Type of a parameter with the bounds of its length, if it is a list."""
    if not known.longest:
        return written
    least = 0 if known.most is None else 1
    return f"Annotated[{written}, Items({least}, {known.longest})]"


def _limits(known: Parameter) -> list[str]:
    return [] if known.longest else _range(known)


def _range(known: Parameter) -> list[str]:
    ends = {"gt": known.above, "ge": known.least, "le": known.most}
    return [f"{name}={value!r}" for name, value in ends.items() if value is not None]


def _default(value: Any) -> str:
    # One structure for all levels needs no list.
    single = isinstance(value, tuple) and len(value) == 1
    return repr(value[0] if single else value)


def _union(word: str, kinds: dict[str, Any]) -> str:
    suffix = "Metric" if word == "Metric" else ""
    names = {name: f"{kind.__name__}{suffix}" for name, kind in kinds.items()}
    tagged = "".join(f'| Annotated[{kind}, Tag("choice[{name}]")]' for name, kind in names.items())
    listed = "".join(f"{name!r}: {kind}," for name, kind in names.items())
    return f'''
class Unknown{word}(Choice):
    """A {word.lower()} without a known name, which is refused for its name alone."""

    model_config = ConfigDict(extra="ignore")

    name: {word}Name


{word.upper()}S: Final[dict[str, type[Choice]]] = {{{listed}}}

{word} = TypeAliasType(
    "{word}",
    Annotated[
        Annotated[{word}Name, Tag(NAME)]
        {tagged}
        | SkipJsonSchema[Annotated[Unknown{word}, Tag(UNKNOWN)]],
        by_name(get_args({word}Name)),
        Field(description="A {word.lower()}: its name, or that and its parameters, as listed by"
        " `GET /v1/structures`."),
    ],
)
"""A {word.lower()}: its name, or that and its parameters."""

{word}ByLevel: TypeAlias = Annotated[
    Annotated[{word}, Tag(ONE)] | Annotated[tuple[{word}, ...], LEVELS, Tag(SEVERAL)],
    one_or_several(),
]
"""A {word.lower()} for all levels, or one for each."""
'''


def _indented(parts: list[str]) -> list[str]:
    return ["    " + line for part in parts for line in part.splitlines()]


_STRUCTURE_IMPORTS: Final = """\
from typing import Annotated, Final, Literal, TypeAlias, get_args

from pydantic import ConfigDict, Field, Tag
from pydantic.json_schema import SkipJsonSchema
from typing_extensions import TypeAliasType

from broker.contracts.strict import Items
from broker.contracts.structures import (
    LEVELS,
    NAME,
    ONE,
    SEVERAL,
    UNKNOWN,
    Choice,
    Invariance,
    Structure,
    StructureParameter,
    by_name,
    one_or_several,
)
"""

_OPTION_IMPORTS: Final = """\
from typing import Annotated, Final, Literal, TypeAlias

from pydantic import Field

from broker.contracts.strict import Items, StrictModel, Topic
from broker.contracts.structure_choices import (
    Descriptor,
    DescriptorByLevel,
    Metric,
    MetricByLevel,
)
from broker.contracts.vertices import Landmark
"""
