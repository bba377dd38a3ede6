"""The options that are parameters of jobs, under the headings that ``--help`` shows them by.

Defaults in brackets are the service's.
"""

from typing import Annotated, Final

import typer

SHAPES: Final = "What is compared of the shapes"
STRUCTURES: Final = "Structures"
SOLVER: Final = "Solver"

Orientation = Annotated[
    bool | None,
    typer.Option(
        "--orientation/--no-orientation",
        help="Tell left from right; takes seconds. The default with a prototype that can.",
    ),
]
Dense = Annotated[bool | None, typer.Option("--dense", help="Extend the match to all vertices.")]
Refine = Annotated[
    str | None, typer.Option(help="gmds: find the points between the target's vertices.")
]
Landmarks = Annotated[
    list[str] | None,
    typer.Option("--landmark", help="Vertices known to correspond, as in 17:203; may be repeated."),
]

Normalise = Annotated[
    bool | None,
    typer.Option(
        help="Scale all shapes to unit area first, or keep the files' units, so that size counts.",
        rich_help_panel=SHAPES,
    ),
]
LargestComponent = Annotated[
    bool | None,
    typer.Option(
        "--largest-component",
        help="Take the largest component of a shape that has several.",
        rich_help_panel=SHAPES,
    ),
]
Simplify = Annotated[
    int | None,
    typer.Option(
        help="Vertices to which larger shapes are simplified first.", rich_help_panel=SHAPES
    ),
]
OcclusionCost = Annotated[
    float | None,
    typer.Option(
        help="Cost of leaving a point unmatched; without it all are matched.",
        rich_help_panel=SHAPES,
    ),
]

Metrics = Annotated[
    list[str] | None,
    typer.Option(
        "--metric",
        help="A metric, as in diffusion:time=0.02; once for each level, coarsest on.",
        rich_help_panel=STRUCTURES,
    ),
]
Descriptors = Annotated[
    list[str] | None,
    typer.Option(
        "--descriptor",
        help="A descriptor, likewise; `isomatch structures` lists what there is.",
        rich_help_panel=STRUCTURES,
    ),
]
Metric = Annotated[
    str | None,
    typer.Option(help="A metric, as in diffusion:time=0.02.", rich_help_panel=STRUCTURES),
]
Descriptor = Annotated[
    str | None,
    typer.Option(
        help="A descriptor, likewise; `isomatch structures` lists what there is.",
        rich_help_panel=STRUCTURES,
    ),
]
Samplings = Annotated[
    list[str] | None,
    typer.Option(
        "--sampling",
        help="A metric in which points are sampled, by turns.",
        rich_help_panel=STRUCTURES,
    ),
]
Eigenpairs = Annotated[
    int | None,
    typer.Option(help="Laplace-Beltrami eigenpairs [100].", rich_help_panel=STRUCTURES),
]
GeodesicMethod = Annotated[
    str | None,
    typer.Option(help="fast_marching (the default), graph or heat.", rich_help_panel=STRUCTURES),
]

Objective = Annotated[
    str | None,
    typer.Option(
        help="l2 (the default), or linf: the least greatest distortion.", rich_help_panel=SOLVER
    ),
]
FirstOrderWeight = Annotated[
    float | None,
    typer.Option(help="Weight of the first-order term, the descriptor's.", rich_help_panel=SOLVER),
]
Beta = Annotated[
    float | None,
    typer.Option(
        help="Weight of the second-order term, the metric's [1.0].", rich_help_panel=SOLVER
    ),
]
CoarsePoints = Annotated[
    int | None,
    typer.Option(
        help="Points of the coarsest level, solved to optimality, 3 to 10 [8].",
        rich_help_panel=SOLVER,
    ),
]
LevelFactor = Annotated[
    int | None,
    typer.Option(help="How many times more points each level has [2].", rich_help_panel=SOLVER),
]
Oversampling = Annotated[
    int | None,
    typer.Option(help="Target samples for each source sample [4].", rich_help_panel=SOLVER),
]
Rho = Annotated[
    float | None,
    typer.Option(
        help="Neighbourhood between levels, in covering radii [1.5].", rich_help_panel=SOLVER
    ),
]
Alternatives = Annotated[
    int | None,
    typer.Option(
        help="Best coarse solutions that are kept and refined [8].", rich_help_panel=SOLVER
    ),
]
TimeLimit = Annotated[
    float | None,
    typer.Option(help="Seconds; the best answer so far is returned.", rich_help_panel=SOLVER),
]
