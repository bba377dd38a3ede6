"""The client's types of parameters, and the options of its command line."""

import re
import textwrap
from collections.abc import Callable, Mapping, Sequence
from typing import Final

from broker.contracts import catalogue
from codegen.described import JOBS, Described, Job
from codegen.python_source import docstring, header, literal

_TYPES: Final = {
    "integer": "int",
    "number": "float",
    "boolean": "bool",
    "string": "str",
    "structure": "StructureChoice",
    "structures": "StructureChoice | Sequence[StructureChoice]",
    "landmarks": "LandmarkPairs",
}
_PYTHON: Final[dict[str, str | Callable[[re.Match[str]], str]]] = {
    r"`GET /v1/structures` lists them": "see :meth:`isomatch.Client.structures`",
    r"\bnull\b": "None",
    r"\b(is|If|if) (true|false)\b": lambda found: f"{found[1]} {found[2].capitalize()}",
    r'"(\w+)"': r'``"\1"``',
}
"""Words of the API's descriptions, and those of Python."""


def parameter_types(jobs: Mapping[str, Sequence[Described]]) -> str:
    """Return the module of the keyword arguments of the client's methods."""
    imports = (
        "from collections.abc import Sequence\n"
        "from typing import Annotated, Final, Literal\n\n"
        "# Pydantic reads a TypedDict of the standard library only from Python 3.12 on.\n"
        "from typing_extensions import TypedDict\n\n"
        "from isomatch._models.arguments import READ_AS_TEXT, LandmarkPairs, StructureChoice"
    )
    types = [_type(job, jobs[job.name]) for job in JOBS]
    return "\n\n".join([header("Keyword arguments of the jobs."), imports, _lists(), *types])


def command_line_options(jobs: Mapping[str, Sequence[Described]]) -> str:
    """Return the module of the options of commands that ask for jobs."""
    imports = (
        "from typing import Final\n\nfrom isomatch._cli.parameter_table import ParameterOption"
    )
    tables = [
        f"{job.name}: Final = ({''.join(map(_option, jobs[job.name]))})\n"
        f'"""Options of a job that :meth:`isomatch.Client.{job.method}` asks for."""'
        for job in JOBS
    ]
    return "\n\n".join([header("Options of the commands that ask for jobs."), imports, *tables])


def _lists() -> str:
    known = catalogue()
    lists = tuple(
        (structure.name, one.name)
        for structure in (*known.metrics, *known.descriptors)
        for one in structure.parameters
        if one.type == "numbers"
    )
    about = docstring("Structures and those of their parameters that are lists.")
    return f"LISTS: Final = {lists!r}\n{about}"


def _type(job: Job, parameters: Sequence[Described]) -> str:
    lines = [
        f'"""Keyword arguments of :meth:`isomatch.Client.{job.method}`; all may be left out.',
        "",
        *textwrap.wrap(
            "Defaults, in brackets, are those of the service. Section and equation numbers are"
            " those of Wang, Bronstein and Paragios, INRIA RR-7333, 2010.",
            96,
        ),
        "",
        "Attributes",
        "----------",
    ]
    for one in parameters:
        lines += [
            one.name,
            *textwrap.wrap(
                _documented(one),
                92,
                initial_indent="    ",
                subsequent_indent="    ",
                break_on_hyphens=False,
            ),
        ]
    lines.append('"""')
    lines += ["", *(f"{one.name}: {_hint(one)}" for one in parameters)]
    body = "\n".join(f"    {line}" if line else "" for line in lines)
    return f"class {job.model.__name__}(TypedDict, total=False):\n{body}\n"


def _hint(one: Described) -> str:
    hint = f"Annotated[Literal{list(one.values)}, READ_AS_TEXT]" if one.values else _TYPES[one.kind]
    return hint + (" | None" if one.nullable else "")


def _documented(one: Described) -> str:
    text = one.description
    for pattern, replacement in _PYTHON.items():
        text = re.sub(pattern, replacement, text)
    text = text.removesuffix(".")
    if one.limits:
        text += f"; {one.limits}"
    return f"{text} [{_default(one)}]."


def _default(one: Described) -> str:
    value = list(one.default) if isinstance(one.default, tuple) else one.default
    text = repr(value).replace("'", '"')
    return f"``{text}``" if '"' in text else text


def _option(one: Described) -> str:
    help_text = one.summary
    if one.values:
        # In brackets, help takes words for markup.
        listed = [f"{value} (default)" if value == one.default else value for value in one.values]
        help_text += f": {', '.join(listed)}"
    if one.kind == "boolean" and one.default:
        help_text += " (the default)"
    if one.limits:
        help_text += f", {one.limits}"
        help_text += "" if one.default in (None, ()) else f" [{one.default}]"
    return (
        f"ParameterOption({one.name!r}, {one.kind!r}, {literal(help_text + '.')}, {one.topic!r}),"
    )
