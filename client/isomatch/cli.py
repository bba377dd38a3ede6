"""The command line: ``isomatch match a.off b.obj`` and what goes with it."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Annotated, Any, cast

import typer
from rich.console import Console

from isomatch import _render as render
from isomatch._client import DEFAULT_URL, URL_VARIABLE, Client
from isomatch._errors import ConnectionFailed, IsomatchError
from isomatch._job import Job
from isomatch._models import JobState
from isomatch._parameters import MatchParameters, StructureChoice, structure_choice

INTERRUPTED = 130
"""Exit code after Ctrl-C, as shells have it."""

app = typer.Typer(
    name="isomatch",
    help="Minimum-distortion correspondence of non-rigid shapes, computed by an isomatch service.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

Url = Annotated[str, typer.Option("--url", envvar=URL_VARIABLE, help="Address of the service.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")]
Mesh = Annotated[
    Path,
    typer.Argument(exists=True, dir_okay=False, readable=True, help="OFF, OBJ, PLY, STL or GLB."),
]
Output = Annotated[
    Path | None, typer.Option("--output", "-o", help="Write the result to this JSON file.")
]
Picture = Annotated[
    Path | None, typer.Option("--picture", help="Write a picture of the result to this PNG file.")
]


@contextmanager
def _connected(url: str) -> Iterator[Client]:
    """Open a client; say in one line what goes wrong, and leave with exit code 1."""
    try:
        with Client(url) as client:
            yield client
    except ConnectionFailed as error:
        _leave(f"{error} (start one with `make serve`, or say where it is with --url)")
    except (IsomatchError, OSError, ValueError) as error:
        _leave(str(error))
    except KeyboardInterrupt:
        typer.echo("interrupted", err=True)
        raise typer.Exit(INTERRUPTED) from None


@contextmanager
def _interrupts_deferred() -> Iterator[None]:
    """Hold a first Ctrl-C back until the end: a job whose id is not known cannot be cancelled."""
    interrupted = False

    def hold_back(number: int, frame: FrameType | None) -> None:
        nonlocal interrupted
        if interrupted:
            raise KeyboardInterrupt
        interrupted = True

    before = signal.signal(signal.SIGINT, hold_back)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if interrupted:
        raise KeyboardInterrupt


def _leave(message: str) -> None:
    typer.echo(f"isomatch: {' '.join(message.split())}", err=True)
    raise typer.Exit(1) from None


def _structures(given: list[str] | None) -> list[StructureChoice]:
    try:
        return [structure_choice(text) for text in given or ()]
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error


def _finish(job: Job, as_json: bool, output: Path | None, picture: Path | None) -> None:
    result = job.result(progress=True)
    if output is not None:
        result.save(output)
    if picture is not None:
        job.save_picture(picture)
    if as_json:
        typer.echo(result.to_json())
    else:
        render.print_match(result, render.standard_output())


@app.command()
def match(
    source: Mesh,
    target: Mesh,
    points: Annotated[int | None, typer.Option(help="Points matched at the finest level.")] = None,
    metric: Annotated[
        list[str] | None,
        typer.Option(help="A metric, as in diffusion:time=0.02; once for each level, coarsest on."),
    ] = None,
    descriptor: Annotated[
        list[str] | None,
        typer.Option(help="A descriptor, likewise; `isomatch structures` lists what there is."),
    ] = None,
    coarse_points: Annotated[
        int | None, typer.Option(help="Points of the coarsest level, solved to optimality.")
    ] = None,
    level_factor: Annotated[
        int | None, typer.Option(help="How many times more points each level has.")
    ] = None,
    oversampling: Annotated[
        int | None, typer.Option(help="Target samples for each source sample.")
    ] = None,
    rho: Annotated[
        float | None, typer.Option(help="Neighbourhood between levels, in covering radii.")
    ] = None,
    beta: Annotated[float | None, typer.Option(help="Weight of the second-order term.")] = None,
    first_order_weight: Annotated[
        float | None, typer.Option(help="Weight of the first-order term.")
    ] = None,
    occlusion_cost: Annotated[
        float | None, typer.Option(help="Cost of leaving a point unmatched.")
    ] = None,
    eigenpairs: Annotated[int | None, typer.Option(help="Laplace-Beltrami eigenpairs.")] = None,
    alternatives: Annotated[
        int | None, typer.Option(help="Best coarse solutions that are kept and refined.")
    ] = None,
    objective: Annotated[
        str | None, typer.Option(help="l2, or linf: the least greatest distortion.")
    ] = None,
    refine: Annotated[
        str | None, typer.Option(help="gmds: find the points between the target's vertices.")
    ] = None,
    normalise: Annotated[
        bool | None,
        typer.Option(help="Scale both shapes to unit area first, or keep the files' units."),
    ] = None,
    largest_component: Annotated[
        bool | None,
        typer.Option("--largest-component", help="Match the largest component of a shape."),
    ] = None,
    simplify: Annotated[
        int | None, typer.Option(help="Vertices to which larger shapes are simplified first.")
    ] = None,
    time_limit: Annotated[
        float | None, typer.Option(help="Seconds; the best answer so far is returned.")
    ] = None,
    as_json: AsJson = False,
    output: Output = None,
    picture: Picture = None,
    url: Url = DEFAULT_URL,
) -> None:
    """Match two meshes and print the correspondences.

    Parameters that are left out take the service's defaults.
    """
    given: dict[str, Any] = {
        "points": points,
        "coarse_points": coarse_points,
        "level_factor": level_factor,
        "oversampling": oversampling,
        "rho": rho,
        "metric": _structures(metric),
        "descriptor": _structures(descriptor),
        "beta": beta,
        "first_order_weight": first_order_weight,
        "occlusion_cost": occlusion_cost,
        "normalise": normalise,
        "eigenpairs": eigenpairs,
        "alternatives": alternatives,
        "objective": objective,
        "refine": refine,
        "largest_component": largest_component,
        "simplify": simplify,
        "time_limit": time_limit,
    }
    parameters = {name: value for name, value in given.items() if value not in (None, [])}
    with _connected(url) as client:
        first, second = client.upload(source), client.upload(target)
        console = Console(stderr=True)
        for path, shape in ((source, first), (target, second)):
            render.print_warnings([f"{path.name}: {text}" for text in shape.warnings], console)
        job: Job | None = None
        try:
            with _interrupts_deferred():
                job = client.match(first, second, **cast(MatchParameters, parameters))
            _finish(job, as_json, output, picture)
        except KeyboardInterrupt:
            if job is not None:
                job.cancel()
                typer.echo(f"job {job.id} cancelled", err=True)
            raise


@app.command()
def result(
    job_id: str,
    as_json: AsJson = False,
    output: Output = None,
    picture: Picture = None,
    url: Url = DEFAULT_URL,
) -> None:
    """Print the result of a job, waiting for it if need be."""
    with _connected(url) as client:
        _finish(client.job(job_id), as_json, output, picture)


@app.command()
def upload(
    meshes: Annotated[list[Path], typer.Argument(exists=True, dir_okay=False)],
    as_json: AsJson = False,
    url: Url = DEFAULT_URL,
) -> None:
    """Upload meshes; the same file again costs nothing."""
    with _connected(url) as client:
        shapes = [client.upload(mesh) for mesh in meshes]
        if as_json:
            _echo_models(shape.model_dump_json() for shape in shapes)
        else:
            render.print_shapes(shapes, render.standard_output())
            for shape in shapes:
                warnings = [f"{shape.name}: {text}" for text in shape.warnings]
                render.print_warnings(warnings, Console(stderr=True))


@app.command()
def structures(as_json: AsJson = False, url: Url = DEFAULT_URL) -> None:
    """List the metrics and descriptors that can be chosen."""
    with _connected(url) as client:
        found = client.structures()
        if as_json:
            typer.echo(found.model_dump_json())
        else:
            render.print_structures(found, render.standard_output())


@app.command()
def shapes(as_json: AsJson = False, url: Url = DEFAULT_URL) -> None:
    """List the uploaded shapes."""
    with _connected(url) as client:
        if as_json:
            _echo_models(shape.model_dump_json() for shape in client.shapes())
        else:
            render.print_shapes(client.shapes(), render.standard_output())


@app.command()
def jobs(
    state: Annotated[
        str | None, typer.Option(help="queued, running, succeeded, failed or cancelled.")
    ] = None,
    as_json: AsJson = False,
    url: Url = DEFAULT_URL,
) -> None:
    """List the jobs."""
    with _connected(url) as client:
        found = client.jobs(cast(JobState | None, state))
        if as_json:
            _echo_models(job.record.model_dump_json() for job in found)
        else:
            render.print_jobs(found, render.standard_output())


@app.command()
def cancel(job_id: str, url: Url = DEFAULT_URL) -> None:
    """Cancel a job, whether it is queued or running."""
    with _connected(url) as client:
        job = client.job(job_id).cancel()
        typer.echo(f"job {job.id} is {job.state}", err=True)


def _echo_models(documents: Iterator[str]) -> None:
    typer.echo("[" + ",\n".join(documents) + "]")


if __name__ == "__main__":
    app()
