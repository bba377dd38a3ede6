"""A process that warms up, runs jobs, and prints as JSON the kernels it compiled or loaded then."""

import json
import sys

import numpy as np

from broker.contracts import MatchParameters, MatchPayload
from solver.control import Control
from solver.matching import MatchOptions
from solver.mesh import triangle_mesh
from solver.prototype import PrototypeOptions, connected_examples, learn_prototype, match_prototype
from solver.shape import Shape
from solver.transfer import carry_landmarks, place_landmarks
from tests.worker.families import member
from tests.worker.figures import blob
from worker.jobs import MatchInput, match_shapes
from worker.jobs.carrying import solver_map
from worker.process.warmup import warm_up

VARIED = {"points": 24}, {"points": 24, "occlusion_cost": 0.05}, {"points": 24, "dense": True}


def variants() -> dict[str, int]:
    """Number of compiled variants of each of the solver's kernels in this process."""
    return {
        f"{name}.{kernel}": len(value.signatures)
        for name, module in list(sys.modules.items())
        if name.startswith("solver")
        for kernel, value in vars(module).items()
        if hasattr(value, "signatures")
    }


def work() -> None:
    """Run the most frequent jobs: matches, the last in doubt, landmarks, and a prototype."""
    meshes = [triangle_mesh(*member(seed, 3)) for seed in range(4)]
    unlike = triangle_mesh(blob(3)[0] * np.array([1.0, 1.5, 0.6]), blob(3)[1])
    for target, changes in zip((*meshes[1:3], unlike), VARIED, strict=True):
        parameters = MatchParameters.model_validate(changes)
        payload = MatchPayload(source="a", target="b", parameters=parameters)
        inputs = MatchInput(meshes[0], None), MatchInput(target, None)
        dense = match_shapes(*inputs, payload, Control()).dense
    assert dense is not None
    assert dense.inverse is not None
    maps = [solver_map(dense, dense.inverse, forwards=forwards) for forwards in (True, False)]
    placed = place_landmarks(("a", None), meshes[0].vertices[:2], meshes[0])
    carry_landmarks(placed.points, (maps[0], maps[1]), meshes[0], unlike)
    options = PrototypeOptions(points=24, components=2)
    examples = connected_examples([Shape(mesh) for mesh in meshes[:3]], options).examples
    prototype = learn_prototype(examples, options)
    match_prototype(prototype, Shape(meshes[3]), MatchOptions(points=24))


def main() -> None:
    """Print the kernels that jobs needed and the warm-up had not compiled."""
    warm_up()
    before = variants()
    work()
    late = [kernel for kernel, count in variants().items() if count > before.get(kernel, 0)]
    print(json.dumps({"kernels": len(before), "late": late}))


if __name__ == "__main__":
    main()
