"""Registrations as tables."""

from collections.abc import Mapping
from pathlib import Path

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Column, Table
from rich.text import Text

from isomatch._cli.render import print_warnings
from isomatch._results import Registration

_SHOWN = 10
"""Components that are printed."""


def print_registration(
    found: Registration, console: Console, failures: Mapping[str, str] | None = None
) -> None:
    """Print how well the template was registered to each specimen, and the components.

    Parameters
    ----------
    found
        The registration.
    console
        Where it is printed.
    failures
        Files that were not uploaded, with the reasons.
    """
    table = Table(
        Column("specimen"),
        Column("id", no_wrap=True),
        Column("flipped", justify="right"),
        Column("confidence"),
        box=SIMPLE_HEAD,
        pad_edge=False,
    )
    for one in found.specimens:
        measures = ["-", f"not registered: {one.reason}"]
        if one.registered:
            reflected = " (reflected)" if one.reflected else ""
            measures = [str(one.flipped), f"{one.confidence}{reflected}"]
        table.add_row(*map(Text, (one.name or "-", one.shape, *measures)))
    for file, reason in (failures or {}).items():
        table.add_row(*map(Text, (Path(file).name, "-", "-", f"not uploaded: {reason}")))
    console.print(table)
    shares = [f"{100.0 * one.explained:.1f} %" for one in found.components[:_SHOWN]]
    if shares:
        console.print(f"variance of the components: {', '.join(shares)}")
    print_warnings(found.warnings, console)
