"""Registrations as tables."""

from collections.abc import Sequence

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Column, Table

from isomatch._cli.render import print_warnings
from isomatch._results import Registration

_SHOWN = 10
"""Components that are printed."""


def print_registration(found: Registration, names: Sequence[str], console: Console) -> None:
    """Print how well the template was registered to each specimen, and the components.

    Parameters
    ----------
    found
        The result.
    names
        Names of the specimens.
    console
        Where it is printed.
    """
    table = Table(
        Column("specimen"),
        Column("distance", justify="right"),
        Column("flipped", justify="right"),
        Column("confidence"),
        box=SIMPLE_HEAD,
        pad_edge=False,
    )
    for name, one in zip(names, found.specimens, strict=True):
        if one.registered:
            distance = f"{one.max_distance:.4f}"
            reflected = " (reflected)" if one.reflected else ""
            table.add_row(name, distance, str(one.flipped), f"{one.confidence}{reflected}")
        else:
            table.add_row(name, "-", "-", f"not registered: {one.reason}")
    console.print(table)
    shares = [f"{100.0 * one.explained:.1f} %" for one in found.components[:_SHOWN]]
    if shares:
        console.print(f"variance of the components: {', '.join(shares)}")
    print_warnings(found.warnings, console)
