"""Weights of the confidence, fitted: ``python -m bench.confidence_fit FILE...``.

The files are those of ``python -m bench.confidence --features FILE``. Prints the weights of a
logistic regression of right answers on the measures, and its calibration, every answer predicted by
a fit to the others.
"""

from dataclasses import asdict
from pathlib import Path

from bench.calibration import calibration, print_calibration
from bench.command_line import command_line, parsed, print_json
from bench.confidence import load_features
from bench.logistic import fit_logistic, held_out_probability


def main() -> None:
    """Fit and print the weights."""
    parser = command_line(__doc__)
    parser.add_argument("files", type=Path, nargs="+", help="written by bench.confidence")
    parser.add_argument("--measures", nargs="+", help="names of those used; all by default")
    arguments = parsed(parser)
    names, measures, right = load_features(arguments.files, arguments.measures)
    fit = fit_logistic(names, measures, right)
    print(f"{'measure':32}{'weight':>14}{'effect of one deviation':>26}")
    for name in names:
        print(f"{name:32}{fit.weights[name]:14.6g}{fit.effects[name]:26.3f}")
    print(f"{'intercept':32}{fit.intercept:14.6g}")
    print_calibration("fitted", calibration(fit.probability(measures), right))
    held_out = held_out_probability(names, measures, right)
    found = calibration(held_out, right)
    print_calibration("held out", found)
    print_json(arguments, {"answers": len(right), **asdict(fit), **found.figures()})


if __name__ == "__main__":
    main()
