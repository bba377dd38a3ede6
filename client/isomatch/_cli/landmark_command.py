"""``isomatch landmarks``: landmarks of a collection of specimens, from one or several templates."""

from collections import deque
from collections.abc import Generator, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Final

import typer

from isomatch._cli import render
from isomatch._cli.exit_codes import Failures, connected
from isomatch._cli.job_runs import echo_link, echo_models, interrupts_deferred
from isomatch._cli.landmark_output import TABLE, LandmarkOutput, document_of, print_landmarks
from isomatch._cli.landmark_templates import check_template, landmarks_of
from isomatch._cli.options import AsJson, Mesh, Meshes, Url, shapes_given
from isomatch._cli.output_files import files_given, folder_given
from isomatch._cli.parameter_options import MATCH
from isomatch._cli.parameter_table import takes
from isomatch._cli.uploads import uploaded
from isomatch._clients import Client, LandmarkJob
from isomatch._http import DEFAULT_URL
from isomatch._landmarks import (
    CarriedLandmarks,
    CoordinateSystem,
    LandmarkFormat,
    LandmarkTemplate,
    stem_of,
    with_same_labels,
)
from isomatch._models import MatchParameters
from isomatch._operations.landmarks import FIXED

AHEAD: Final = 4
"""Specimens whose matches are queued while the landmarks of another are awaited."""


@dataclass
class _Collection:
    """Specimens on their way.

    Attributes
    ----------
    client
        The connection.
    templates, parameters
        What they are matched with, and how.
    as_json
        Keep the standard output for JSON.
    failures
        Specimens that have no landmarks.
    pending
        Jobs that were started and are not awaited yet, with these names.
    """

    client: Client
    templates: Sequence[LandmarkTemplate]
    parameters: MatchParameters
    as_json: bool
    failures: Failures
    pending: deque[tuple[str, LandmarkJob]] = field(default_factory=deque)

    def landmarks(self, specimens: Sequence[str]) -> Generator[tuple[str, CarriedLandmarks]]:
        """Yield the landmarks of each specimen that does not fail; at the end, cancel the rest."""
        left = deque(specimens)
        try:
            while left or self.pending:
                while left and len(self.pending) <= AHEAD:
                    self._start(left.popleft())
                if self.pending:
                    specimen, job = self.pending[0]
                    count = len(specimens) - len(left) - len(self.pending) + 1
                    if not self.as_json:
                        typer.echo(f"{count} of {len(specimens)}: {specimen}", err=True)
                    with self.failures.named(specimen):
                        yield specimen, job.result(progress=not self.as_json)
                        for job_id in job.job_ids:
                            echo_link(self.client.base_url, job_id, self.as_json)
                    self.pending.popleft()
                    if specimen in self.failures.reasons:
                        job.cancel()
        finally:
            for _, job in self.pending:
                job.cancel()

    def _start(self, specimen: str) -> None:
        with self.failures.named(specimen):
            (shape,) = uploaded(self.client, [specimen], self.as_json)
            # The ids are known before a first Ctrl-C, so that the jobs can be cancelled.
            with interrupts_deferred():
                job = self.client.landmarks(self.templates, shape, **self.parameters)
                self.pending.append((specimen, job))


def _more(given: list[str] | None) -> list[str]:
    for one in given or ():
        shape, _, file = one.partition("=")
        if not Path(file).is_file():
            raise typer.BadParameter(f"{one!r} is not of the form MESH=LANDMARKS, with two files")
        shapes_given(shape)
    return given or []


@takes(MATCH, without=(*FIXED, "orientation"))
def landmarks(
    template: Mesh,
    landmarks: Annotated[
        Path,
        typer.Argument(
            exists=True,
            dir_okay=False,
            readable=True,
            help="Its landmarks (.mrk.json, .fcsv, .csv, .tps, .txt of MorphoJ).",
        ),
    ],
    specimens: Meshes,
    parameters: MatchParameters,
    folder: Annotated[
        Path,
        typer.Option(
            "--output", "-o", callback=folder_given, help="Folder of the files, made if missing."
        ),
    ],
    more: Annotated[
        list[str] | None,
        typer.Option(
            "--template",
            metavar="MESH=LANDMARKS",
            callback=_more,
            help="Another template and its landmarks; the answer is the median of three or more,"
            " of two that of the surer one. May be repeated.",
        ),
    ] = None,
    file_format: Annotated[
        LandmarkFormat,
        typer.Option(
            "--format",
            help="Format of the files; tps and txt (MorphoJ) have all specimens in one.",
        ),
    ] = "mrk.json",
    coordinates: Annotated[
        CoordinateSystem,
        typer.Option(
            case_sensitive=False,
            help="Coordinate system of the meshes, to which landmarks of 3D Slicer are converted.",
        ),
    ] = "LPS",
    as_json: AsJson = False,
    url: Url = DEFAULT_URL,
) -> None:
    """Transfer landmarks from a template to specimens, each with a confidence.

    Every specimen gets a file of its own in the folder; landmarks.csv has the confidence of each
    landmark. A specimen that fails is named, and the others go on.
    """
    files = [(template, landmarks)]
    files += [(shape, Path(file)) for shape, _, file in (one.partition("=") for one in more or ())]
    names = [stem_of(one) for one in specimens]
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise typer.BadParameter(f"two specimens are called {twice!r}", param_hint="SPECIMENS")
    if file_format == "csv" and TABLE in (f"{name}.csv" for name in names):
        raise typer.BadParameter(f"{TABLE} is the table of all specimens", param_hint="SPECIMENS")
    inputs = [*specimens, *(one for pair in files for one in pair)]
    files_given(folder, [TABLE, *LandmarkOutput.files(names, file_format)], inputs)
    with connected(url, as_json) as client:
        read = [landmarks_of(file, shape, coordinates) for shape, file in files]
        sets = with_same_labels(read, [str(file) for _, file in files])
        shapes = uploaded(client, [shape for shape, _ in files], as_json)
        for (mesh, file), shape, given in zip(files, shapes, read, strict=True):
            check_template(client, mesh, shape, given, file, coordinates, as_json)
        templates = list(map(LandmarkTemplate, shapes, sets))
        folder.mkdir(exist_ok=True)
        output = LandmarkOutput(folder, file_format, coordinates)
        failures = Failures(as_json)
        running = _Collection(client, templates, parameters, as_json, failures)
        with closing(running.landmarks(specimens)) as every:
            for specimen, found in every:
                output.add(stem_of(specimen), found)
        if as_json:
            echo_models(document_of(name, found) for name, found in output.found.items())
        elif output.found:
            print_landmarks(output.found, render.standard_output())
        if failures.reasons and not as_json:
            old = output.outdated(map(stem_of, failures.reasons))
            remark = f"; of an earlier run: {', '.join(map(str, old))}" if old else ""
            typer.echo(
                f"isomatch: no landmarks for {', '.join(failures.reasons)}{remark}", err=True
            )
        failures.check()
