"""Tables of parameters, structures and problems in the documents."""

import re
from collections.abc import Callable, Mapping, Sequence
from itertools import groupby
from operator import attrgetter
from typing import Final

from broker.contracts import ProblemType, Structure, catalogue
from codegen.described import JOBS, Described, first_sentence

DOCUMENTS: Final = ("docs/api.md", "docs/parameters.md", "docs/mathematics.md", "README.md")
"""Documents with parts between ``<!-- generated: NAME -->`` and ``<!-- end -->``."""

Jobs = Mapping[str, Sequence[Described]]


def document(text: str, jobs: Jobs) -> str:
    """Return a document with its generated parts renewed."""
    pattern = re.compile(r"(<!-- generated: (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)
    return pattern.sub(lambda found: found[1] + _PARTS[found[2]](jobs) + found[3], text)


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [heads, ["---"] * len(heads), *rows]
    return "".join(
        "| " + " | ".join(one.replace("|", "\\|") for one in line) + " |\n" for line in lines
    )


def _parameters(parameters: Sequence[Described]) -> str:
    rows = [
        (f"`{one.name}`", _values(one), _default(one.default), one.description)
        for one in parameters
    ]
    return _table(("parameter", "values", "default", "meaning"), rows)


def _values(one: Described) -> str:
    if one.values:
        return " or ".join(f"`{value}`" for value in one.values)
    if one.kind == "landmarks":
        return f"`[[source, target], ...]`, {one.limits} pairs"
    return one.limits or {"boolean": "true or false"}.get(one.kind, one.kind)


def _default(value: object) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return ", ".join(f"`{one}`" for one in value)
    return f"`{value}`" if isinstance(value, str) else str(value)


def _summary(parameters: Sequence[Described]) -> str:
    """Parameters most users look for, in a sentence each, with values and default."""
    names = {
        "metric": [one.name for one in catalogue().metrics],
        "descriptor": [one.name for one in catalogue().descriptors],
    }
    rows = []
    shown = [one for one in parameters if one.topic in ("", "Shapes") or one.name in names]
    for one in sorted(shown, key=lambda one: one.name not in ("points", *names)):
        values = ", ".join(f"`{name}`" for name in names.get(one.name, one.values))
        default = _default(one.default) or "none"
        rows.append((f"`{one.name}`", f"{one.summary}{values and ': '}{values}", default))
    return _table(("parameter", "meaning", "default"), rows)


def _structures() -> str:
    rows = []
    for one in (*catalogue().metrics, *catalogue().descriptors):
        parameters = ", ".join(f"`{own.name}` = {_short(own.default)}" for own in one.parameters)
        meaning = first_sentence(one.description)
        invariant = ". ".join(filter(None, (_invariant(one), one.remarks)))
        rows.append((f"`{one.name}`", meaning, one.formula, parameters, invariant, one.source))
    heads = ("name", "meaning", "formula", "parameters (on unit area)", "invariant to", "source")
    return _table(heads, rows)


def _problems() -> str:
    status = attrgetter("status")
    rows = [
        (str(number), ", ".join(f"`{one.slug}`" for one in problems))
        for number, problems in groupby(sorted(ProblemType, key=status), key=status)
    ]
    return _table(("status", "types"), rows)


def _short(default: object) -> str:
    if isinstance(default, tuple):
        return f"{len(default)} values from {default[0]:.2g} to {default[-1]:.2g}"
    return str(default)


def _invariant(one: Structure) -> str:
    words = {"yes": "{}", "approx": "approximately {}"}
    rows = one.invariance.model_dump().items()
    return ", ".join(words[degree].format(name) for name, degree in rows if degree in words)


def _of(job: str) -> Callable[[Jobs], str]:
    return lambda jobs: _parameters(jobs[job])


_PARTS: Final[dict[str, Callable[[Jobs], str]]] = {
    **{job.name.lower(): _of(job.name) for job in JOBS},
    "problems": lambda jobs: _problems(),
    "structures": lambda jobs: _structures(),
    "summary": lambda jobs: _summary(jobs["MATCH"]),
}
