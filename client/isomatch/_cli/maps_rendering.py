"""Consistent maps as tables."""

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Column, Table

from isomatch._cli.render import print_warnings
from isomatch._results import CollectionPair, ConsistentMaps


def print_maps(found: ConsistentMaps, console: Console) -> None:
    """Print the pairs with confidence and cycle errors, and the shapes that do not fit."""
    names = {one.shape: one.name or one.shape for one in found.shapes}
    table = Table(
        Column("source"),
        Column("target"),
        Column("cycle error", justify="right"),
        Column("confidence"),
        Column("through"),
        box=SIMPLE_HEAD,
        pad_edge=False,
    )
    for pair in found.pairs:
        said = str(pair.confidence) if pair.mapped else f"no map: {pair.reason}"
        through = ", ".join(names[shape] for shape in pair.through)
        table.add_row(names[pair.source], names[pair.target], _errors(pair), said, through)
    console.print(table)
    if found.cycle_error_before is not None and found.cycle_error is not None:
        errors = _change(found.cycle_error_before, found.cycle_error)
        console.print(f"mean cycle error: {errors}")
    for shape in found.shapes:
        if not shape.fits:
            console.print(f"{names[shape.shape]} does not fit: {shape.reason}")
    print_warnings(found.warnings, console)


def _errors(pair: CollectionPair) -> str:
    if pair.cycle_error_before is None or pair.cycle_error is None:
        return "-"
    return _change(pair.cycle_error_before, pair.cycle_error)


def _change(before: float, after: float) -> str:
    return f"{after:.3f}" if before == after else f"{before:.3f} -> {after:.3f}"
