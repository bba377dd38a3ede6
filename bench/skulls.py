"""Accuracy on hollow, thin-walled shapes: ``python -m bench.skulls``.

Generated individuals like scanned skulls are matched densely in pairs. Printed are the mean and the
median distance of all vertices from their true places, in millimetres of a length of 22, the share
farther than 1 mm, the confidence, and seconds.
"""

import time
from itertools import combinations

import numpy as np
from scipy.spatial.transform import Rotation

from bench.command_line import command_line, parsed, print_json
from solver.matching import MatchOptions, match
from solver.mesh import triangle_mesh
from solver.shape import Shape
from synthetic import SKULL_LENGTH, Skull, skull

_FAR = 1.0


def main() -> None:
    """Match the individuals in pairs, print a table."""
    parser = command_line(__doc__)
    parser.add_argument("--individuals", type=int, default=4, help="matched in pairs")
    parser.add_argument("--first", type=int, default=1, help="seed of the first one")
    parser.add_argument("--variation", type=float, default=0.5, help="in millimetres")
    parser.add_argument("--spacing", type=float, default=0.2, help="of the grid, in millimetres")
    arguments = parsed(parser)
    seeds = range(arguments.first, arguments.first + arguments.individuals)
    made = [skull(seed, arguments.variation, arguments.spacing) for seed in seeds]
    shapes = [_shape(one, seed) for seed, one in zip(seeds, made, strict=True)]
    print(f"{'pair':10}{'vertices':>16}{'mean':>8}{'median':>8}{'far':>8}{'sure':>8}{'s':>8}")
    rows = []
    for i, j in combinations(range(len(made)), 2):
        started = time.perf_counter()
        found = match(shapes[i], shapes[j], MatchOptions(dense=True))
        seconds = time.perf_counter() - started
        assert found.dense is not None
        assert found.confidence is not None
        corners = made[j].vertices[found.dense.faces]
        images = np.einsum("nc,ncd->nd", found.dense.barycentric, corners)
        truth = made[j].displacement(made[i].rest[found.dense.source])
        scale = SKULL_LENGTH / np.ptp(made[j].vertices[:, 0])
        apart = scale * np.linalg.norm(images - truth, axis=1)
        rows.append((apart.mean(), np.median(apart), (apart > _FAR).mean()))
        sizes = f"{shapes[i].n_vertices} {shapes[j].n_vertices}"
        figures = "".join(f"{one:8.3f}" for one in (*rows[-1], found.confidence.probability))
        print(f"{f'{seeds[i]} {seeds[j]}':10}{sizes:>16}{figures}{seconds:8.1f}", flush=True)
    mean, median, far = np.mean(rows, axis=0).tolist()
    print(f"\npairs {len(rows)}   mean {mean:.3f} mm   median {median:.3f}   far {far:.3f}")
    print_json(arguments, {"pairs": len(rows), "mean": mean, "median": median, "far": far})


def _shape(one: Skull, seed: int) -> Shape:
    """A skull in any position."""
    turn = Rotation.random(random_state=seed).as_matrix()
    return Shape(triangle_mesh(one.vertices @ turn, one.faces))


if __name__ == "__main__":
    main()
