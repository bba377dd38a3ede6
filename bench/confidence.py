"""Calibration of the confidence of answers: ``python -m bench.confidence``.

Matches a broad mix of generated pairs, of which many answers are wrong, and compares the
probability that an answer says it is right with the share that is: mean error to the direct truth
of at most 0.1. Pairs of different classes have no right answer; they are counted apart.

``--features`` saves, for each pair, the measures that the confidence was computed from and whether
the answer was right; ``python -m bench.confidence_fit`` fits the weights to them.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from bench.calibration import PROBABLY_RIGHT, Calibration, calibration, print_calibration
from bench.command_line import command_line, parsed, print_json
from bench.map_error import WRONG, map_error
from bench.varied_pairs import CONDITIONS, DIFFERENT, KINDS, VariedPair, varied_pair
from solver.arrays import BoolArray, FloatArray
from solver.matching import MatchOptions, match


@dataclass(frozen=True)
class ConfidentAnswer:
    """An answer with its confidence and the truth.

    Parameters
    ----------
    kind, condition
        Of the pair.
    error
        Mean direct error over √area; infinite for shapes of different classes.
    probability
        That the answer is right, as it says.
    reasons
        For doubt.
    measures
        That the probability was computed from, by name.
    """

    kind: str
    condition: str
    error: float
    probability: float
    reasons: tuple[str, ...]
    measures: dict[str, float]

    @property
    def right(self) -> bool:
        """Whether the answer counts as right."""
        return self.error <= WRONG


def with_landmarks(pair: VariedPair, options: MatchOptions, count: int) -> MatchOptions:
    """Give some points of known partners, drawn at random, as landmarks.

    Unlike points at extremities, all of them may lie between left and right.
    """
    ours, theirs = pair.source.truth, pair.target.truth
    if ours is None or theirs is None or not count:
        return options
    drawn = np.random.default_rng(len(ours)).choice(len(ours), count, replace=False)
    here = pair.source.shape.mesh.vertex_ids[ours[drawn]]
    there = pair.target.shape.mesh.vertex_ids[theirs[drawn]]
    return replace(options, landmarks=tuple(zip(here.tolist(), there.tolist(), strict=True)))


def answered(pair: VariedPair, options: MatchOptions) -> ConfidentAnswer:
    """Match a pair densely."""
    found = match(pair.source.shape, pair.target.shape, options)
    assert found.dense is not None
    assert found.confidence is not None
    known = pair.kind != DIFFERENT
    error = map_error(pair.source, pair.target, found.dense).direct if known else np.inf
    said = found.confidence
    return ConfidentAnswer(
        pair.kind, pair.condition, error, said.probability, said.reasons, dict(said.measures)
    )


def calibration_of(answers: list[ConfidentAnswer]) -> Calibration:
    """Compare the probabilities of answers with what is right."""
    return calibration(
        np.array([one.probability for one in answers]),
        np.array([one.right for one in answers]),
    )


def feature_table(answers: list[ConfidentAnswer]) -> tuple[list[str], FloatArray]:
    """Names of all measures, and (P, M) their values; NaN where an answer lacks one."""
    names = sorted({name for one in answers for name in one.measures})
    rows = [[one.measures.get(name, np.nan) for name in names] for one in answers]
    return names, np.array(rows, dtype=np.float64).reshape(len(answers), len(names))


def save_features(path: Path, answers: list[ConfidentAnswer]) -> None:
    """Write what weights can be fitted to: one row an answer."""
    names, measures = feature_table(answers)
    np.savez_compressed(
        path,
        names=np.array(names, dtype=np.str_),
        measures=measures,
        right=np.array([one.right for one in answers]),
        error=np.array([one.error for one in answers]),
        probability=np.array([one.probability for one in answers]),
        kind=np.array([one.kind for one in answers]),
        condition=np.array([one.condition for one in answers]),
    )


def load_features(
    paths: list[Path], chosen: list[str] | None = None
) -> tuple[list[str], FloatArray, BoolArray]:
    """Read what :func:`save_features` wrote.

    Parameters
    ----------
    paths
        Files that all have these measures.
    chosen
        Names of some measures; all by default. Answers that were refined have others than those
        that were not.

    Returns
    -------
    names, measures, right
        Of the answers of all files that have these measures: M names, (P, M) and (P,).

    Raises
    ------
    ValueError
        The files hold different measures, or not the chosen ones.
    """
    tables = []
    for path in paths:
        with np.load(path, allow_pickle=False) as file:
            tables.append({name: file[name] for name in ("names", "measures", "right")})
    names = tables[0]["names"].tolist() if chosen is None else chosen
    known = [one["names"].tolist() for one in tables]
    if any(set(names) - set(one) or (chosen is None and len(names) < len(one)) for one in known):
        raise ValueError("the files hold different measures; choose some that all have")
    columns = [[one.index(name) for name in names] for one in known]
    measures = np.concatenate(
        [one["measures"][:, places] for one, places in zip(tables, columns, strict=True)]
    )
    right = np.concatenate([one["right"] for one in tables])
    kept = np.isfinite(measures).all(axis=1)
    return names, measures[kept], right[kept]


def main() -> None:
    """Match the pairs, print the reliability table."""
    parser = command_line(__doc__)
    parser.add_argument("--pairs", type=int, default=135, help="number of pairs")
    parser.add_argument("--first", type=int, default=0, help="number of the first pair")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--condition", choices=list(CONDITIONS), help="of all targets")
    parser.add_argument("--landmarks", type=int, default=0, help="known points that are given")
    parser.add_argument("--features", type=Path, help="file (.npz) for the measures")
    arguments = parsed(parser)
    options = MatchOptions(dense=True)
    answers = []
    print(f"{'':5}{'kind':26}{'condition':12}{'error':>8}{'said':>7}  reasons for doubt")
    for number in range(arguments.first, arguments.first + arguments.pairs):
        pair = varied_pair(number, arguments.seed, arguments.condition)
        one = answered(pair, with_landmarks(pair, options, arguments.landmarks))
        answers.append(one)
        error = "none" if one.kind == DIFFERENT else f"{one.error:.4f}"
        mark = "wrong, sure" if not one.right and one.probability >= PROBABLY_RIGHT else ""
        said = "; ".join([*([mark] if mark else []), *one.reasons])
        print(
            f"{number:<5}{one.kind:26}{one.condition:12}{error:>8}{one.probability:7.3f}  {said}",
            flush=True,
        )
        if arguments.features:
            save_features(arguments.features, answers)
    figures = report(answers)
    print_json(arguments, figures)


def report(answers: list[ConfidentAnswer]) -> dict[str, float | None]:
    """Print the tables, and return the figures."""
    known = [one for one in answers if one.kind != DIFFERENT]
    different = [one for one in answers if one.kind == DIFFERENT]
    print(f"\n{'kind':26}{'pairs':>7}{'right':>7}{'sure':>7}{'wrong and sure':>16}")
    for kind in KINDS:
        rows = [one for one in answers if one.kind == kind]
        sure = [one for one in rows if one.probability >= PROBABLY_RIGHT]
        wrong = sum(not one.right for one in sure)
        right = sum(one.right for one in rows)
        print(f"{kind:26}{len(rows):7}{right:7}{len(sure):7}{wrong:16}")
    figures: dict[str, float | None] = {"pairs": len(known), "different": len(different)}
    if known:
        found = calibration_of(known)
        print_calibration("pairs of one class", found)
        figures |= found.figures()
    if different:
        doubted = float(np.mean([one.probability < PROBABLY_RIGHT for one in different]))
        print(f"\npairs of different classes: {len(different)}, {doubted:.1%} called doubtful")
        figures["doubted_of_different"] = doubted
    return figures


if __name__ == "__main__":
    main()
