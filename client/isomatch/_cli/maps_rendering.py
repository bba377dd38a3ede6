"""Consistent maps as tables."""

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Column, Table
from rich.text import Text

from isomatch._cli.render import print_warnings
from isomatch._results import CollectionPair, CollectionShape, ConsistentMaps, change


def print_maps(found: ConsistentMaps, console: Console) -> None:
    """Print the pairs with confidence and cycle errors, and the shapes with their ids."""
    names = {one.shape: one.name or one.shape for one in found.shapes}
    table = Table(
        Column("source"),
        Column("target"),
        Column("cycle error", justify="right"),
        Column("confidence"),
        Column("fits"),
        Column("through"),
        box=SIMPLE_HEAD,
        pad_edge=False,
    )
    for pair in found.pairs:
        said = str(pair.confidence) if pair.mapped else f"no map: {pair.reason}"
        through = ", ".join(names[shape] for shape in pair.through)
        fits = "yes" if pair.fits else "no"
        row = (names[pair.source], names[pair.target], _errors(pair), said, fits, through)
        table.add_row(*map(Text, row))
    console.print(table)
    shapes = Table(
        Column("shape"),
        Column("id", no_wrap=True),
        Column("cycle error", justify="right"),
        Column("agreement"),
        box=SIMPLE_HEAD,
        pad_edge=False,
    )
    for one in found.shapes:
        reason, pairs = found.disagreement(one), found.pairs_of(one)
        fitting = sum(pair.fits for pair in pairs)
        agreement = "fits" if fitting == len(pairs) else f"fits in {fitting} of {len(pairs)} pairs"
        if reason is not None:
            agreement = f"does not fit: {reason}"
        shapes.add_row(*map(Text, (one.name or "-", one.shape, _errors(one), agreement)))
    console.print(shapes)
    if found.cycle_error_before is not None and found.cycle_error is not None:
        errors = change(found.cycle_error_before, found.cycle_error)
        console.print(f"mean cycle error: {errors}")
    print_warnings(found.warnings, console)


def _errors(one: CollectionPair | CollectionShape) -> str:
    if one.cycle_error_before is None or one.cycle_error is None:
        return "-"
    return change(one.cycle_error_before, one.cycle_error)
