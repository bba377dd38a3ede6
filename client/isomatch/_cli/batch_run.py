"""Matches of one source with several targets, as one job: a file for each in a folder."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

import typer

from isomatch._cli import render
from isomatch._cli.exit_codes import REFUSED, no_service, problem_document, report
from isomatch._cli.job_runs import cancelled_by_interrupt
from isomatch._cli.output_files import files_given, names_folder, output_folder_given
from isomatch._clients import Client, Job
from isomatch._errors import IsomatchError, Unauthorized
from isomatch._models import MatchParameters, Shape
from isomatch._operations.result_files import MATCH_FORMATS, SURFACES
from isomatch._results import Batch


@dataclass(frozen=True)
class MatchFolder:
    """The folder of a file for each target.

    Attributes
    ----------
    folder
        The folder; None to write no files.
    file_format
        Ending of the files.
    """

    folder: Path | None
    file_format: str

    @classmethod
    def checked(
        cls,
        output: str | None,
        source: str,
        targets: Sequence[str],
        file_format: str | None,
        dense: bool,
    ) -> "MatchFolder":
        """Return the folder, made if it is missing, if all files can be written in it.

        `output` is its name, which may end like that of a file if it exists or has a slash.

        Raises
        ------
        typer.BadParameter
            One cannot or is read by the command, or two targets have the same name.
        """
        if output is None:
            if file_format is not None:
                _refuse("it needs --output FOLDER", "--format")
            return cls(None, "")
        ending = file_format or "json"
        if ending not in (known := ("json", *MATCH_FORMATS)):
            _refuse(f"{ending!r} is none of {', '.join(known)}", "--format")
        if ending in SURFACES and not dense:
            _refuse(f"{ending} shows a map of all vertices; add --dense", "--format")
        folder = Path(output)
        if folder.suffix[1:].lower() in known and not names_folder(output):
            _refuse(
                "several targets have a file each, and so has --format: name a folder, as in"
                f" --output {folder.stem} --format {folder.suffix[1:].lower()}",
                "--output",
            )
        names = [Path(one).stem for one in targets]
        if len(set(names)) < len(names):
            twice = next(name for name in names if names.count(name) > 1)
            _refuse(f"two targets are called {twice!r}, and would have one file", "TARGETS")
        output_folder_given(folder).mkdir(exist_ok=True)
        files_given(folder, (f"{name}.{ending}" for name in names), [source, *targets])
        return cls(folder, ending)

    def file_of(self, target: str) -> Path | None:
        """Return the file of a target, None if none is written."""
        name = f"{Path(target).stem}.{self.file_format}"
        return None if self.folder is None else self.folder / name


def run_batch(
    client: Client,
    source: Shape | str,
    given: Sequence[tuple[str, Shape]],
    parameters: MatchParameters,
    output: MatchFolder,
    as_json: bool,
    wait: bool,
) -> None:
    """Match a source with targets, write a file for each as it ends, and print a summary.

    Parameters
    ----------
    client
        The connection.
    source
        The source, uploaded.
    given
        The targets as they were given, which name the files, and uploaded.
    parameters
        Of the matches.
    output
        Folder of the files.
    as_json
        Print the result as JSON.
    wait
        Wait for the matches; if False, print the job's id, or its record as JSON.

    Raises
    ------
    typer.Exit
        A match has failed, or its file could not be written; all others are there.
    """
    targets = [target for target, _ in given]

    def start() -> Job[Batch]:
        return client.match_many(source, [shape for _, shape in given], **parameters)

    with cancelled_by_interrupt(start, client.base_url, as_json) as job:
        if not wait:
            typer.echo(job.record.model_dump_json() if as_json else job.id)
            return
        unwritten = _written(job, targets, output, as_json)
        result: Batch = job.result()
    if as_json:
        typer.echo(result.to_json())
    else:
        render.print_batch(result, render.standard_output())
    if unwritten or result.succeeded < len(targets):
        raise typer.Exit(REFUSED)


def _written(job: Job[Batch], targets: Sequence[str], output: MatchFolder, as_json: bool) -> bool:
    """Write the files as matches end; return whether one could not be written."""
    failed, ended = False, 0
    target_of = {one.job: name for one, name in zip(job.matches().matches, targets, strict=True)}
    for match in job.ended_matches():
        ended += 1
        target = target_of[match.id]
        if not as_json:
            typer.echo(f"{ended} of {len(targets)}: {target} {match.state}", err=True)
        file = output.file_of(target)
        if file is None or match.state != "succeeded":
            continue
        try:
            match.save(file)
        except (IsomatchError, OSError) as error:
            if no_service(error) or isinstance(error, Unauthorized):
                raise
            failed = True
            message = f"{file}: {error} (job {match.id})"
            document = problem_document(error, message) | {"file": str(file), "job": match.id}
            report(document, f"isomatch: {message}", as_json)
    return failed


def _refuse(message: str, option: str) -> NoReturn:
    raise typer.BadParameter(message, param_hint=option)
