"""Prototypes as tables for a terminal or a text file."""

from collections.abc import Iterable
from typing import Any

from rich.console import Console
from rich.text import Text

from isomatch._cli.render import listing, local, named_values, print_warnings
from isomatch._results import LearnedPrototype, Prototype


def print_prototypes(prototypes: Iterable[Prototype], console: Console) -> None:
    """Print prototypes, one in a row."""
    table = listing("id", "version", "points", "examples", "created")
    table.add_column("name", overflow="fold")
    for prototype in prototypes:
        table.add_row(
            prototype.id,
            str(prototype.version),
            str(prototype.points),
            str(prototype.examples),
            local(prototype.created),
            Text(prototype.name),
        )
    console.print(table)


def print_prototype(prototype: Prototype, console: Console) -> None:
    """Print the record of a prototype."""
    console.print(named_values(_values(prototype)))
    _print_left_out(prototype, console)


def print_learned(learned: LearnedPrototype, console: Console) -> None:
    """Print the result of learning a prototype."""
    rows = _values(learned.prototype)
    if "total" in learned.timings:
        rows["seconds"] = f"{learned.timings['total']:.2f}"
    console.print(named_values(rows))
    _print_left_out(learned.prototype, console)
    print_warnings(learned.warnings, console)


def _values(prototype: Prototype) -> dict[str, str]:
    parameters = prototype.parameters
    return {
        "id": prototype.id,
        "name": prototype.name,
        "version": str(prototype.version),
        "points": str(prototype.points),
        "components": f"at most {prototype.components}",
        "examples": str(prototype.examples),
        "metric": _structures(parameters.get("metric")),
        "descriptor": _structures(parameters.get("descriptor")),
        "eigenpairs": str(parameters.get("eigenpairs")),
        "normalised": "yes" if parameters.get("normalise") else "no",
        "reference": prototype.reference or "unknown, as the prototype was uploaded",
        "created": local(prototype.created),
    }


def _print_left_out(prototype: Prototype, console: Console) -> None:
    for example in prototype.learned_from or ():
        if not example.used:
            console.print(Text(f"left out: {example.shape}: {example.reason}"), soft_wrap=True)


def _structures(given: Any) -> str:
    several = given if isinstance(given, list | tuple) else [given]
    return ", ".join(str(one.get("name") if isinstance(one, dict) else one) for one in several)
