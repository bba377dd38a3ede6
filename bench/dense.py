"""Accuracy of dense maps: ``python -m bench.dense``.

Mean geodesic error over √area of all vertices' images with known truth, per pair of shapes of a
class: direct, on the surface and at vertices, and against the better of the direct and the mirrored
truth; whether the confidence of the answers was justified; and seconds. With ``--data`` the class
is a file's name up to its first digit. ``--sound`` leaves out points whose known partner lies on
another part of the body (:mod:`bench.sound_truth`). ``--objects`` matches generated bones, stones,
leaves and other things that are not bodies (:mod:`synthetic.objects`).
"""

import time
from dataclasses import dataclass

import numpy as np

from bench.calibration import calibration, print_calibration
from bench.collection import KnownShape, known_pairs, object_pairs, pair_options
from bench.command_line import command_line, parsed, print_json
from bench.map_error import COMPARED, MapError, error_figures, map_error
from bench.sound_truth import with_sound_truth
from solver.matching import Match, MatchOptions, match
from solver.shape import Shape

MAPPING = "registration", "dense map"
"""Stages of a match that count as mapping."""


@dataclass(frozen=True)
class DenseAnswer:
    """A dense map between two shapes, judged.

    Parameters
    ----------
    error
        Against the truth.
    probability
        That the answer is right, by its confidence.
    seconds_matching, seconds_mapping
        Of sparse match and dense map, spectra known.
    """

    error: MapError
    probability: float
    seconds_matching: float
    seconds_mapping: float


def judged(
    source: KnownShape, target: KnownShape, options: MatchOptions, most: int = COMPARED
) -> tuple[DenseAnswer, Match]:
    """Match two shapes of one class densely, and compare with the truth."""
    started = time.perf_counter()
    found = match(source.shape, target.shape, options)
    seconds = time.perf_counter() - started
    assert found.dense is not None
    assert found.confidence is not None
    mapping = sum(found.timings.get(stage, 0.0) for stage in MAPPING)
    error = map_error(source, target, found.dense, most)
    return DenseAnswer(error, found.confidence.probability, seconds - mapping, mapping), found


def main() -> None:
    """Map the shapes of the pairs, print a table."""
    parser = command_line(__doc__, data=True)
    parser.add_argument("--points", type=int, default=32, help="matched before")
    pair_options(parser, classes=3)
    parser.add_argument("--compared", type=int, default=COMPARED, help="known points, at most")
    parser.add_argument("--sound", action="store_true", help="leave out torn truth")
    parser.add_argument("--objects", type=int, default=0, help="pairs of each kind of objects")
    parser.add_argument("--first", type=int, default=0, help="seed of the first objects")
    parser.add_argument("--deformation", type=float, default=1.0, help="of the objects")
    arguments = parsed(parser)
    if arguments.objects:
        objects = object_pairs(arguments.objects, arguments.first, arguments.deformation)
        pairs = objects[:: arguments.every]
    else:
        pairs = known_pairs(parser, arguments)
    spectra = [_spectral_seconds(one) for one in {id(s): s for p in pairs for s in p}.values()]
    options = MatchOptions(points=arguments.points, dense=True)
    heads = "direct", "vertices", "better", "<= 0.05", "sure", "match s", "map s"
    print(f"{'pair':40}" + "".join(f"{head:>10}" for head in heads))
    match(Shape(pairs[0][0].shape.mesh), Shape(pairs[0][1].shape.mesh), options)  # compiles
    answers = []
    for source, target in pairs:
        known = with_sound_truth(source, target) if arguments.sound else (source, target)
        answer, _ = judged(*known, options, arguments.compared)
        answers.append(answer)
        _print_row(f"{source.name} {target.name}", answer)
    figures = summary(answers, float(np.mean(spectra)))
    print("\n" + "   ".join(f"{k} {v:.4g}" for k, v in figures.items() if v is not None))
    print_json(arguments, figures)


def summary(answers: list[DenseAnswer], seconds_spectrum: float) -> dict[str, float | None]:
    """Print the calibration, and return all figures.

    Parameters
    ----------
    answers
        Of all pairs, at least one.
    seconds_spectrum
        Mean time of a shape's spectrum.
    """
    found = calibration(
        np.array([one.probability for one in answers]),
        np.array([one.error.right for one in answers]),
    )
    print_calibration("confidence", found)
    matching = float(np.mean([one.seconds_matching for one in answers]))
    mapping = float(np.mean([one.seconds_mapping for one in answers]))
    return {
        **error_figures([one.error for one in answers]),
        **found.figures(),
        "seconds_matching": matching,
        "seconds_mapping": mapping,
        "seconds": matching + mapping,
        "seconds_spectra": 2.0 * seconds_spectrum,
    }


def _print_row(name: str, answer: DenseAnswer) -> None:
    error = answer.error
    errors = "".join(f"{one:10.4f}" for one in (error.direct, error.at_vertices, error.better))
    rest = (error.within[0], answer.probability, answer.seconds_matching, answer.seconds_mapping)
    mark = "" if error.right else "  wrong"
    print(f"{name:40}{errors}" + "".join(f"{one:10.2f}" for one in rest) + mark, flush=True)


def _spectral_seconds(one: KnownShape) -> float:
    started = time.perf_counter()
    one.shape.spectrum()
    return time.perf_counter() - started


if __name__ == "__main__":
    main()
