"""Examples at the end of ``--help`` of the longer commands."""

from typing import Final


def _epilog(*examples: tuple[str, str]) -> str:
    # Lines of one paragraph stay lines; the last one keeps the indentation of the others.
    lines = [f"  [dim]# {caption}[/dim]\n  {command}" for caption, command in examples]
    end = "Exit codes and errors: isomatch --help"
    return "\n".join(["[bold]Examples[/bold]", *lines, "", end])


MATCH_EXAMPLES: Final = _epilog(
    ("32 points, as a table and as a picture", "isomatch match a.off b.obj --picture match.png"),
    (
        "all vertices, both shapes in corresponding colours",
        "isomatch match a.off b.obj --dense --output match.glb",
    ),
    (
        "one mesh with many, a file for each in results/",
        "isomatch match a.off scan*.ply --dense -o results --format ply",
    ),
    (
        "a landmark: vertex 17 of a.off corresponds to vertex 203 of b.obj",
        "isomatch match a.off b.obj --landmark 17:203",
    ),
    (
        "diffusion distances on the coarsest level, then geodesic distances",
        "isomatch match a.off b.obj --metric diffusion:time=0.02 --metric geodesic",
    ),
    (
        "without normalisation of sizes, and with unmatched points",
        "isomatch match a.off b.obj --no-normalise --occlusion-cost 0.05",
    ),
)

COMPARE_EXAMPLES: Final = _epilog(
    (
        "classes from the names cat0.off, cat1.off, horse0.off, ...",
        "isomatch compare *.off --labels-from-names --picture matrix.png",
    ),
    (
        "the nearest shapes of each as JSON",
        "isomatch compare *.off --json | jq .nearest",
    ),
)

TRANSFER_EXAMPLES: Final = _epilog(
    (
        "a segmentation of a.off, a label in each line, for b.obj",
        "isomatch transfer a.off b.obj parts.seg --what labels -o parts_of_b.csv",
    ),
    (
        "skinning weights of the mesh itself",
        "isomatch transfer a.glb b.obj --what skinning -o b.glb",
    ),
    (
        "colours of the source, along a match that was made before",
        "isomatch transfer 5f0c2f0e3b9d4c0c8e6f1a2b3c4d5e6f --what colors -o b.ply",
    ),
)

LEARN_EXAMPLES: Final = _epilog(
    (
        "poses of one template, whose vertices correspond by their numbers",
        "isomatch prototype learn human*.off --name human --shared-connectivity",
    ),
    (
        "independent meshes, which are matched with the first",
        "isomatch prototype learn scan*.ply --name human --points 16",
    ),
    (
        "a match with the prototype",
        "isomatch match p-1f0c2f0e3b9d4c0c8e6f1a2b3c4d5e6f stranger.off",
    ),
)

LANDMARKS_EXAMPLES: Final = _epilog(
    (
        "Slicer markups out/scan0.mrk.json, ..., and a table out/landmarks.csv",
        "isomatch landmarks template.ply template.mrk.json scan*.ply -o out",
    ),
    (
        "the median of two templates",
        "isomatch landmarks a.ply a.tps scan*.ply -o out --template b.ply=b.fcsv",
    ),
)

REGISTER_EXAMPLES: Final = _epilog(
    (
        "out/scan0.ply, ... with common vertices, out/mean.ply, out/components.npz and a picture",
        "isomatch register template.off scan*.ply -o out",
    ),
    (
        "shape without size",
        "isomatch register template.off scan*.ply -o out --scale",
    ),
)

MAPS_EXAMPLES: Final = _epilog(
    ("all maps as arrays map_0_1, map_1_0, map_0_2, ...", "isomatch maps scan*.ply -o maps.npz"),
    (
        "pairs that do not fit",
        "isomatch maps scan*.ply --json | jq '.pairs[] | select(.fits | not)'",
    ),
)
