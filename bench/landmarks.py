"""Accuracy of carried landmarks: ``python -m bench.landmarks``.

Landmarks at vertices of known truth are carried from a template to a specimen as the service does.
Printed are the mean geodesic error over √area, the share within 0.05, and how well each measure
tells landmarks within 0.05 from the others (AUC: 0.5 is chance, 1 perfect), and the calibration of
the confidence. Without ``--data`` the pairs are the generated ones of :mod:`bench.varied_pairs`;
``--fit`` prints the weights of the confidence that fit them best. ``--templates`` carries from
several shapes of a class and takes the median.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np
from isomatch import Geometry
from isomatch._landmarks import FromTemplate, merged
from sklearn.metrics import roc_auc_score

from bench.calibration import calibration, print_calibration
from bench.collection import KnownShape, collection, require
from bench.command_line import command_line, parsed, print_json
from bench.logistic import fit_logistic
from bench.map_error import WRONG, known_points
from bench.surface_error import corner_errors
from bench.varied_pairs import DIFFERENT, varied_pair
from solver.arrays import FloatArray, IntArray
from solver.matching import MatchOptions, match
from solver.mesh import surface_tree
from solver.registration import DenseCorrespondence
from solver.transfer import (
    NEAR,
    carry_landmarks,
    confidence_features,
    landmark_confidence,
    place_landmarks,
)

DECIMALS = 4
"""Of barycentric coordinates in results of the service."""


@dataclass(frozen=True, eq=False)
class CarriedPair:
    """Landmarks of one specimen, judged.

    Parameters
    ----------
    name
        Of the specimen and its templates.
    probability
        Confidence of the matches, mean.
    errors, round_trips, distortions, spreads, confidence
        (n,) of the landmarks; errors are geodesic, over √area.
    """

    name: str
    probability: float
    errors: FloatArray
    round_trips: FloatArray
    distortions: FloatArray
    spreads: FloatArray
    confidence: FloatArray


def carried(
    templates: list[KnownShape], specimen: KnownShape, landmarks: int, options: MatchOptions
) -> CarriedPair:
    """Carry landmarks from templates to a specimen, and compare with the truth.

    Parameters
    ----------
    templates, specimen
        Of one class, with known truth.
    landmarks
        Their number at most, but for rounding, evenly among the known points.
    options
        Of the match, dense.
    """
    surface = specimen.shape.mesh
    first, truths = known_points(templates[0], specimen, landmarks)
    labels = tuple(map(str, range(len(first))))
    each, probabilities = [], []
    for template in templates:
        found = match(template.shape, specimen.shape, options)
        assert found.dense is not None
        assert found.dense.inverse is not None
        assert found.confidence is not None
        mesh = template.shape.mesh
        vertices = first if template is templates[0] else _partners(templates[0], template, first)
        placed = place_landmarks(labels, mesh.vertices[vertices], mesh)
        maps = _stored(found.dense), _stored(found.dense.inverse)
        moved = carry_landmarks(placed.points, maps, mesh, surface)
        said = found.confidence.probability
        measures = moved.round_trip, moved.distortion
        sure = landmark_confidence(said, *measures)
        places = moved.images.positions(surface)
        each.append(FromTemplate(places, sure, *measures, placed.from_surface))
        probabilities.append(said)
    geometry = Geometry(surface.vertices, surface.faces, surface.vertex_ids, None)
    answer = merged(labels, each, np.array(probabilities), geometry)
    faces, weights = surface_tree(surface.vertices, surface.faces).nearest(answer.positions)
    errors = corner_errors(specimen, surface.faces[faces], weights, truths[0])
    return CarriedPair(
        " ".join(one.name for one in (*templates, specimen)),
        float(np.mean(probabilities)),
        errors,
        answer.round_trip,
        answer.distortion,
        answer.spread,
        answer.confidence,
    )


def _partners(first: KnownShape, other: KnownShape, vertices: IntArray) -> IntArray:
    """Vertices of another shape of the class that correspond to known ones of the first."""
    assert first.truth is not None
    assert other.truth is not None
    places = [int(np.flatnonzero(first.truth == vertex)[0]) for vertex in vertices]
    return other.truth[places]


def _stored(dense: DenseCorrespondence) -> DenseCorrespondence:
    return replace(dense, barycentric=dense.barycentric.round(DECIMALS))


def generated(first: int, seed: int) -> Iterator[tuple[list[KnownShape], KnownShape]]:
    """Generate pairs of known truth without end."""
    while True:
        pair = varied_pair(first, seed)
        first += 1
        if pair.kind != DIFFERENT:
            yield [pair.source], pair.target


def from_classes(
    shapes: list[KnownShape], templates: int
) -> Iterator[tuple[list[KnownShape], KnownShape]]:
    """Take each shape of known truth as a specimen, the next ones of its class as templates."""
    for shape in shapes:
        alike = [one for one in shapes if one.category == shape.category and one.truth is not None]
        if shape.truth is not None and len(alike) > templates:
            place = next(place for place, one in enumerate(alike) if one is shape)
            yield [alike[(place + step + 1) % len(alike)] for step in range(templates)], shape


def summary(pairs: list[CarriedPair]) -> dict[str, float | None]:
    """Print the calibration of the confidence, and return all figures."""
    errors = np.concatenate([one.errors for one in pairs])
    sure = np.concatenate([one.confidence for one in pairs])
    found = calibration(sure, errors <= NEAR)
    print_calibration("confidence", found)
    return {
        "specimens": len(pairs),
        "landmarks": len(errors),
        "mean_error": float(errors.mean()),
        "median_error": float(np.median(errors)),
        "within_0_05": float((errors <= NEAR).mean()),
        "auc_confidence": _area_under_curve(errors, -sure),
        "auc_match": _area_under_curve(
            errors, -np.repeat([one.probability for one in pairs], [len(o.errors) for o in pairs])
        ),
        "auc_round_trip": _area_under_curve(errors, _joined(pairs, "round_trips")),
        "auc_distortion": _area_under_curve(errors, _joined(pairs, "distortions")),
        "auc_spread": _area_under_curve(errors, _joined(pairs, "spreads")),
        **found.figures(),
    }


def print_fit(pairs: list[CarriedPair]) -> None:
    """Print the weights that fit the landmarks of right matches best; one template each."""
    right = [one for one in pairs if one.errors.mean() <= WRONG]
    rows = np.concatenate([confidence_features(one.round_trips, one.distortions) for one in right])
    near = np.concatenate([one.errors for one in right]) <= NEAR
    fit = fit_logistic(["round trip", "distortion"], rows, near)
    print(f"intercept {fit.intercept:.3f}   weights {dict(fit.weights)}")


def _joined(pairs: list[CarriedPair], name: str) -> FloatArray:
    found: FloatArray = np.concatenate([getattr(one, name) for one in pairs])
    return found


def _area_under_curve(errors: FloatArray, measure: FloatArray) -> float | None:
    """Probability that the measure is greater for a wrong landmark than for a right one."""
    wrong = errors > NEAR
    if wrong.all() or not wrong.any() or not np.isfinite(measure).all():
        return None
    return float(roc_auc_score(wrong, measure))


def main() -> None:
    """Carry the landmarks, print a table."""
    parser = command_line(__doc__, data=True)
    parser.add_argument("--most", type=int, default=60, help="specimens, at most")
    parser.add_argument("--landmarks", type=int, default=40, help="of each specimen")
    parser.add_argument("--templates", type=int, default=1, help="of each specimen")
    parser.add_argument("--seed", type=int, default=0, help="of the generated pairs")
    parser.add_argument("--first", type=int, default=0, help="number of the first generated pair")
    parser.add_argument("--fit", action="store_true", help="fit the weights of the confidence")
    arguments = parsed(parser)
    if arguments.data or arguments.templates > 1:
        shapes = collection(arguments.data, classes=3)
        of_classes = list(from_classes(shapes, arguments.templates))
        require(parser, of_classes)
        tasks = iter(of_classes)
    else:
        tasks = generated(arguments.first, arguments.seed)
    options = MatchOptions(dense=True)
    pairs = []
    print(f"{'templates, specimen':60}{'match':>8}{'error':>8}{'<= 0.05':>8}{'trip':>8}{'sure':>8}")
    for templates, specimen in islice(tasks, arguments.most):
        one = carried(templates, specimen, arguments.landmarks, options)
        pairs.append(one)
        figures = one.errors.mean(), (one.errors <= NEAR).mean(), one.round_trips.mean()
        row = (one.probability, *figures, one.confidence.mean())
        print(f"{one.name:60}" + "".join(f"{value:8.3f}" for value in row), flush=True)
    if arguments.fit:
        print_fit(pairs)
    found = summary(pairs)
    print("\n" + "   ".join(f"{k} {v:.4g}" for k, v in found.items() if v is not None))
    print_json(arguments, found)


if __name__ == "__main__":
    main()
