"""What ``--help`` of the longer commands ends with: how they are used."""

from typing import Final


def _epilog(*examples: tuple[str, str]) -> str:
    # Lines of one paragraph stay lines; the last one keeps the others' indentation.
    told = [f"  [dim]# {what}[/dim]\n  {command}" for what, command in examples]
    end = "Exit codes and how errors are told: isomatch --help"
    return "\n".join(["[bold]Examples[/bold]", *told, "", end])


MATCH_EXAMPLES: Final = _epilog(
    ("32 points, as a table and as a picture", "isomatch match a.off b.obj --picture match.png"),
    (
        "all vertices, left told from right, the result in a file",
        "isomatch match a.off b.obj --dense --output match.json",
    ),
    (
        "vertex 17 of the one is known to be vertex 203 of the other",
        "isomatch match a.off b.obj --landmark 17:203",
    ),
    (
        "diffusion distances first, geodesic ones on the finer levels",
        "isomatch match a.off b.obj --metric diffusion:time=0.02 --metric geodesic",
    ),
    (
        "size counts, and points may stay alone",
        "isomatch match a.off b.obj --no-normalise --occlusion-cost 0.05",
    ),
)

COMPARE_EXAMPLES: Final = _epilog(
    (
        "cat0.off, cat1.off, horse0.off, ...: classes from the names",
        "isomatch compare *.off --labels-from-names --picture matrix.png",
    ),
    (
        "the nearest shapes of each, for a program",
        "isomatch compare *.off --json | jq .nearest",
    ),
)

LEARN_EXAMPLES: Final = _epilog(
    (
        "poses of one template: vertex i of each corresponds",
        "isomatch prototype learn human*.off --name human --shared-connectivity",
    ),
    (
        "meshes of their own: they are matched to the first",
        "isomatch prototype learn scan*.ply --name human --points 16",
    ),
    (
        "what it is good for",
        "isomatch match p-1f0c2f0e3b9d4c0c8e6f1a2b3c4d5e6f stranger.off",
    ),
)
