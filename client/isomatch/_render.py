"""Results as tables for a terminal or a text file."""

from collections.abc import Iterable

from rich.console import Console
from rich.table import Table
from rich.text import Text

from isomatch._job import Job
from isomatch._match import Match
from isomatch._models import Shape


def print_match(match: Match, console: Console) -> None:
    """Print the correspondences of a match and what is proven of it."""
    table = Table("source", "target", "cost", title="correspondences", title_justify="left")
    for column in table.columns:
        column.justify = "right"
    for pair in match.correspondences:
        table.add_row(str(pair.source), str(pair.target), f"{pair.cost:.6g}")
    console.print(table)
    console.print(match_summary(match))
    print_warnings(match.warnings, console)


def match_summary(match: Match) -> Table:
    """Return the figures of a match as a table of names and values."""
    distortion = match.distortion
    first_order = "none" if distortion.first_order is None else f"{distortion.first_order:.6g}"
    proof = "yes: no better one exists" if match.certified else "no: the gap says how far it can be"
    rows = {
        "distortion, first order": first_order,
        "distortion, second order": f"{distortion.second_order:.6g}",
        "distortion, largest": f"{distortion.linf:.6g}",
        "Gromov-Hausdorff": f"{match.gromov_hausdorff:.6g}",
        "energy": f"{match.energy:.6g}",
        "lower bound": f"{match.lower_bound:.6g}",
        "gap": f"{match.gap:.3g}",
        "certified": proof,
        "certified levels": certified_levels(match),
        "alternatives": str(len(match.alternatives)),
        "unmatched": str(len(match.unmatched)),
        "seconds": f"{match.timings['total']:.2f}" if "total" in match.timings else "unknown",
    }
    table = Table(show_header=False, box=None, pad_edge=False)
    for name, value in rows.items():
        table.add_row(name, Text(value))
    return table


def certified_levels(match: Match) -> str:
    """Return which levels carry a proof, as in ``8 points, not 16, not 32``."""
    return ", ".join(
        f"{level.points} points" if level.certified else f"not {level.points}"
        for level in match.levels
    )


def print_shapes(shapes: Iterable[Shape], console: Console) -> None:
    """Print shapes, one in a row."""
    table = Table("id", "name", "type", "vertices", "faces", "closed", "uploaded")
    for shape in shapes:
        table.add_row(
            Text(shape.id, no_wrap=True),
            Text(shape.name),
            shape.file_type,
            str(shape.vertices),
            str(shape.faces),
            "yes" if shape.closed else "no",
            f"{shape.created:%Y-%m-%d %H:%M}",
        )
    console.print(table)


def print_jobs(jobs: Iterable[Job], console: Console) -> None:
    """Print jobs, one in a row."""
    table = Table("id", "kind", "state", "stage", "done", "queued")
    for job in jobs:
        table.add_row(
            Text(job.id, no_wrap=True),
            job.kind,
            job.state,
            Text(job.progress.stage),
            f"{job.progress.fraction:.0%}",
            f"{job.created:%Y-%m-%d %H:%M}",
        )
    console.print(table)


def print_warnings(warnings: Iterable[str], console: Console) -> None:
    """Print warnings, one in a line."""
    for warning in warnings:
        console.print(Text(f"warning: {warning}"), soft_wrap=True)
