"""Results as tables for a terminal or a text file."""

import os
from collections.abc import Iterable, Mapping
from datetime import datetime
from itertools import repeat
from pathlib import Path
from typing import Final

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Column, Table
from rich.text import Text

from isomatch._cli.less_energy import less_energy
from isomatch._models import (
    Confidence,
    JobRecord,
    RefinedPoint,
    Refinement,
    SampleProof,
    Shape,
    Structure,
    StructureParameter,
    Structures,
)
from isomatch._models.confidence import SURE
from isomatch._results import Batch, BatchMatch, Dissimilarities, Match, Transfer

FILE_WIDTH = 120
"""Width of output that is not printed on a terminal, in columns."""

_OF_ALL: Final = " (stages: sums over all workers)"
"""What the stages of a comparison are, which may take more time than its total."""


def standard_output() -> Console:
    """Return the console for results."""
    console = Console(highlight=False)
    if not console.is_terminal and "COLUMNS" not in os.environ:
        console.width = FILE_WIDTH
    return console


def standard_error() -> Console:
    """Return the console for messages and progress."""
    return Console(stderr=True)


def print_match(match: Match, console: Console) -> None:
    """Print the correspondences of a match and its certificate."""
    columns = [Column(name, justify="right") for name in ("source", "target", "cost")]
    if match.refinement is not None:
        columns.append(Column("between the target's vertices, with weights"))
    table = Table(*columns, box=SIMPLE_HEAD, pad_edge=False)
    refined = map(_refined, match.refinement.points) if match.refinement is not None else repeat("")
    for pair, between in zip(match.correspondences, refined, strict=False):
        table.add_row(str(pair.source), str(pair.target), f"{pair.cost:.6g}", between)
    console.print(table)
    console.print(match_summary(match))
    print_warnings(match.warnings, console)


def _refined(point: RefinedPoint) -> str:
    corners = zip(point.vertices, point.weights, strict=True)
    return ", ".join(f"{vertex}: {weight:.3f}" for vertex, weight in corners)


def match_summary(match: Match) -> Table:
    """Return confidence, distortion, energy and bounds of a match as a table."""
    distortion = match.distortion
    first_order = "none" if distortion.first_order is None else f"{distortion.first_order:.6g}"
    proof = "no, see the gap"
    if match.certified:
        proof = "yes: no better correspondence among this answer's candidates"
        if match.confidence is not None and match.confidence.in_doubt:
            proof = "only among this answer's candidates: the answer itself is in doubt"
    explanation = less_energy(match)
    rows = {
        **({} if match.confidence is None else {"answer": _answer(match.confidence)}),
        "distortion, first order": first_order,
        "distortion, second order": f"{distortion.second_order:.6g}",
        "distortion, maximal": f"{distortion.linf:.6g}",
        "Gromov-Hausdorff": _gromov_hausdorff(match),
        "energy": f"{match.energy:.6g}",
        "lower bound": f"{match.lower_bound:.6g}",
        "gap": f"{match.gap:.3g}",
        "certified": proof,
        "certified levels": certified_levels(match),
        **({} if match.proof is None else {"over all samples": _sample_proof(match.proof)}),
        "alternatives": _alternatives(match),
        **({} if explanation is None else {"less energy": explanation}),
        "refinement": _refinement(match.refinement),
        "dense map": "none" if match.dense is None else f"of {len(match.dense.source)} vertices",
        **({} if match.overlap is None else {"overlap": str(match.overlap)}),
        "unmatched": str(len(match.unmatched)),
        **({} if match.misfit is None else {"misfit": f"{match.misfit:.3g}, 1 is typical"}),
        "seconds": _seconds(match.timings),
    }
    return named_values(rows)


def _seconds(timings: Mapping[str, float]) -> str:
    """Return the time of a job, with the stages that took a tenth of it or more."""
    if "total" not in timings:
        return "unknown"
    total = timings["total"]
    stages = sorted((-value, name) for name, value in timings.items() if name != "total")
    parts = [f"{name} {-value:.2f}" for value, name in stages if -value >= 0.1 * total]
    return f"{total:.2f}" + (f": {', '.join(parts)}" if parts else "")


def _answer(found: Confidence) -> str:
    if found.in_doubt:
        return str(found)
    return f"{'sure' if found.probability >= SURE else 'likely right'}, {found}"


def named_values(rows: Mapping[str, str]) -> Table:
    """Return a table of names and values."""
    table = Table(show_header=False, box=None, pad_edge=False)
    for name, value in rows.items():
        table.add_row(name, Text(value))
    return table


def _alternatives(match: Match) -> str:
    words = [other.relation.replace("_", " ") for other in match.alternatives if other.relation]
    count = str(len(match.alternatives))
    return f"{count}: {', '.join(words)}" if words else count


def _refinement(found: Refinement | None) -> str:
    if found is None:
        return "none"
    what = f"alternative {found.hypothesis}" if found.hypothesis else "this correspondence"
    return f"of {what}: stress {found.stress:.3g}, initially {found.initial_stress:.3g}"


def _sample_proof(proof: SampleProof) -> str:
    bound = "proven" if proof.certified else f"gap {proof.gap:.3g}"
    return f"least energy {proof.energy:.6g}, {bound}"


def _gromov_hausdorff(match: Match) -> str:
    found = match.gromov_hausdorff_distance
    if found is None:
        return f"at most {match.gromov_hausdorff:.6g}"
    bound = "proven" if found.certified else f"at least {found.lower_bound:.6g}"
    return f"{found.value:.6g}, {bound}"


def certified_levels(match: Match) -> str:
    """Return the certified levels, as in ``8 points, not 16, not 32``."""
    return ", ".join(
        f"{level.points} points" if level.certified else f"not {level.points}"
        for level in match.levels
    )


def print_batch(result: Batch, console: Console) -> None:
    """Print the matches of a batch, one in a row."""
    columns = [Column("target"), Column("state"), Column("answer", overflow="fold")]
    columns += [Column("second order", justify="right"), Column("job", no_wrap=True)]
    table = Table(*columns, box=SIMPLE_HEAD, pad_edge=False)
    for match in result.matches:
        summary = match.summary
        order = "" if summary is None else f"{summary.distortion.second_order:.6g}"
        name = match.target_name or match.target
        table.add_row(*map(Text, (name, match.state, _short(match), order, match.job)))
    console.print(table)
    rows = {"succeeded": f"{result.succeeded} of {len(result.matches)}"}
    if "total" in result.timings:
        rows["seconds"] = f"{result.timings['total']:.2f}"
    console.print(named_values(rows))
    print_warnings(result.warnings, console)


def _short(match: BatchMatch) -> str:
    if match.error is not None:
        return match.error.summary
    confidence = None if match.summary is None else match.summary.confidence
    return "" if confidence is None else str(confidence)


def print_transfer(transfer: Transfer, console: Console) -> None:
    """Print what was carried: the landmarks, or the attributes, which are in files."""
    if transfer.points is not None:
        table = Table(Column("vertices"), Column("weights"), box=SIMPLE_HEAD, pad_edge=False)
        for point in transfer.points:
            if point is None:
                table.add_row("missing", "")
                continue
            weights = ", ".join(f"{weight:.4f}" for weight in point.weights)
            table.add_row(", ".join(map(str, point.vertices)), weights)
        console.print(table)
    carried = ", ".join(one.name for one in transfer.attributes)
    rows = {
        transfer.what: carried or f"{len(transfer.points or ())} points",
        "from": transfer.source_name or transfer.source,
        "to": transfer.target_name or transfer.target,
        **({} if transfer.points is not None else {transfer.on: str(transfer.rows)}),
        **({} if transfer.confidence is None else {"answer": _answer(transfer.confidence)}),
    }
    console.print(named_values(rows))
    print_warnings(transfer.warnings, console)


def print_dissimilarities(result: Dissimilarities, console: Console) -> None:
    """Print a collection: the nearest shape of each, and the certificate."""
    names = result.names or ("",) * len(result.shapes)
    called = [Path(name).stem or shape for name, shape in zip(names, result.shapes, strict=True)]
    columns = [Column("shape"), Column("nearest"), Column("dissimilarity", justify="right")]
    labels = result.labels
    if labels is not None:
        columns.insert(1, Column("label"))
        columns.append(Column("average precision", justify="right"))
    table = Table(*columns, box=SIMPLE_HEAD, pad_edge=False)
    for place, (name, ranked) in enumerate(zip(called, result.nearest, strict=True)):
        row = [name, called[ranked[0]], f"{result.matrix[place, ranked[0]]:.6g}"]
        if labels is not None:
            precision = (result.average_precisions or ())[place]
            row.insert(1, labels[place])
            row.append("single" if precision is None else f"{precision:.3f}")
        table.add_row(*map(Text, row))
    console.print(table)
    console.print(_collection_summary(result))
    print_warnings(result.warnings, console)


def _collection_summary(result: Dissimilarities) -> Table:
    count = len(result.shapes)
    pairs = count * (count - 1) // 2
    rows = {
        "pairs": str(pairs),
        "certified": "all of them"
        if result.certified
        else f"all but {len(result.uncertified)} of them",
        "seconds": f"{_seconds(result.timings)}{_OF_ALL if len(result.timings) > 1 else ''}",
    }
    if result.mean_average_precision is not None and result.precision_at_1 is not None:
        rows["mean average precision"] = f"{result.mean_average_precision:.4f}"
        rows["precision at 1"] = f"{result.precision_at_1:.4f}"
    return named_values(rows)


def print_shapes(shapes: Iterable[Shape], console: Console) -> None:
    """Print shapes, one in a row."""
    table = listing("id", "type", "vertices", "faces", "uploaded")
    table.add_column("name", overflow="fold")
    for shape in shapes:
        table.add_row(
            shape.id,
            shape.file_type,
            str(shape.vertices),
            str(shape.faces),
            local(shape.created),
            Text(shape.name),
        )
    console.print(table)


def print_structures(structures: Structures, console: Console) -> None:
    """Print the metrics and the descriptors, one in a row."""
    _print_kind("metric", structures.metrics, console)
    _print_kind("descriptor", structures.descriptors, console)
    console.print(
        Text("Invariances are those of shapes that are not normalised. Parameters are given as in"),
        Text("diffusion:time=0.02 or hks:times=0.1,1, in units of a surface of area 1."),
    )


def _print_kind(kind: str, structures: Iterable[Structure], console: Console) -> None:
    table = listing(kind, "bending", "topology", "scale")
    table.add_column("parameters", overflow="fold")
    table.add_column("", overflow="fold")
    for structure in structures:
        invariance = structure.invariance
        table.add_row(
            structure.name,
            invariance.bending,
            invariance.topology,
            invariance.scale,
            Text("\n".join(map(_parameter, structure.parameters))),
            Text(structure.description),
        )
    console.print(table)


def _parameter(parameter: StructureParameter) -> str:
    value = parameter.default
    default = f"{value[0]:.2g},...,{value[-1]:.2g}" if isinstance(value, tuple) else f"{value:g}"
    unit = f" ({parameter.unit})" if parameter.unit in ("length", "area") else ""
    return f"{parameter.name}={default}{unit}"


def print_jobs(jobs: Iterable[JobRecord], console: Console) -> None:
    """Print jobs, one in a row."""
    table = listing("id", "kind", "state", "done", "queued")
    table.add_column("of", overflow="fold")
    table.add_column("stage", overflow="fold")
    for job in jobs:
        table.add_row(
            job.id,
            job.kind,
            job.state,
            f"{job.progress.fraction:.0%}",
            local(job.created),
            Text(_subject(job, short=True)),
            Text(job.stage),
        )
    console.print(table)


def _subject(record: JobRecord, short: bool = False) -> str:
    """Shapes or prototype of a job, by their ids, or for short by their names if they have any."""

    def shown(one: str | None, name: str | None = None) -> str:
        return (name if short else None) or one or ""

    if record.source is not None:
        source_name, target_name, *_ = (*record.names, None, None)
        others = record.shape_count - (record.source in record.shapes)
        several = "1 shape" if others == 1 else f"{others} shapes"
        target = several if record.target is None else shown(record.target, target_name)
        return f"{shown(record.source, source_name)} -> {target}"
    few = record.shape_count == len(record.shapes) <= (2 if short else 20)
    names = record.names if len(record.names) == len(record.shapes) else [None] * len(record.shapes)
    shapes = ", ".join(map(shown, record.shapes, names)) if few else f"{record.shape_count} shapes"
    return ": ".join(part for part in (record.name, shown(record.prototype), shapes) if part)


def print_job(record: JobRecord, console: Console) -> None:
    """Print the record of a job."""
    rows = {
        "id": record.id,
        "kind": record.kind,
        "of": _subject(record),
        "state": record.state,
        "progress": f"{record.progress.fraction:.0%}, {record.stage}",
        "queued": local(record.created),
        "started": "not yet" if record.started is None else local(record.started),
        "ended": "not yet" if record.ended is None else local(record.ended),
    }
    if record.error is not None:
        rows["error"] = record.error.summary
    if record.caller is not None:
        rows["caller"] = record.caller
    if record.webhook is not None:
        rows["webhook"] = f"{record.webhook.url}: {record.webhook.state}"
    console.print(named_values(rows))


def event_line(record: JobRecord) -> str:
    """Return the state of a job in one line."""
    line = f"{datetime.now():%H:%M:%S}  {record.state:9}  {record.progress.fraction:4.0%}"
    if record.error is not None:
        return f"{line}  {record.error.summary}"
    return f"{line}  {record.stage}"


def listing(*names: str) -> Table:
    """Return a table without a frame, whose columns are not shortened."""
    # Shortened ids are of no use: only the last column wraps.
    return Table(*(Column(name, no_wrap=True) for name in names), box=SIMPLE_HEAD, pad_edge=False)


def local(time: datetime) -> str:
    """Return a time in the local time zone."""
    return f"{time.astimezone():%Y-%m-%d %H:%M}"


def print_warnings(warnings: Iterable[str], console: Console) -> None:
    """Print warnings, one in a line."""
    for warning in warnings:
        console.print(Text(f"warning: {warning}"), soft_wrap=True)
