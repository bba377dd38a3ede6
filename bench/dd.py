"""Public graph matching instances through our solver: ``python -m bench.dd FILE...``.

For every ``.dd`` file the energy found, its lower bound and the seconds it took. Where the user has
installed ``pylibmgm`` (GPL, so no dependency of ours), its energies and times stand beside.
"""

import importlib
import importlib.util
import tempfile
import time
from pathlib import Path

from bench.command_line import command_line, parsed, print_json
from bench.dd_format import parse_dd, read_dd, read_text
from solver.arrays import IntArray
from solver.control import UNLIMITED, Control
from solver.labelling import LabellingProblem, Solution
from solver.optimisation import minimise

SMALL = "p 17 2 18 1\n" + "\n".join(
    [*(f"a {x} {x} 0 -1" for x in range(17)), "a 17 0 1 -1", "e 1 17 -1"]
)
"""A small instance, solved once so that everything is compiled."""

_GAP = 1e-6
"""Relative gap at which the table stops."""


def solve(problem: LabellingProblem, seconds: float, gap: float) -> Solution[IntArray]:
    """Solve an instance within a time limit, to a relative gap."""
    return minimise(problem, iterations=UNLIMITED, gap=gap, control=Control().within(seconds))


def solve_by_pylibmgm(path: Path) -> dict[str, float]:
    """Energy and seconds of pylibmgm's heuristic on a file; nothing if it is not installed."""
    if importlib.util.find_spec("pylibmgm") is None:
        return {}
    io, solver = (importlib.import_module(f"pylibmgm.{name}") for name in ("io", "solver"))
    with tempfile.NamedTemporaryFile("w", suffix=".dd") as plain:
        plain.write(read_text(path))
        plain.flush()
        model = io.parse_dd_file_gm(plain.name)
    started = time.perf_counter()
    energy = float(solver.solve_gm(model).evaluate())
    return {"pylibmgm_energy": energy, "pylibmgm_seconds": time.perf_counter() - started}


def main() -> None:
    """Solve the files, print a table."""
    parser = command_line(__doc__)
    parser.add_argument("files", type=Path, nargs="+", metavar="FILE", help=".dd, .dd.xz, ...")
    parser.add_argument("--seconds", type=float, default=10.0, help="time limit of each")
    arguments = parsed(parser)
    solve(parse_dd(SMALL), 60.0, 0.0)  # compiles
    print(f"{'instance':24}{'size':>12}{'terms':>9}{'energy':>14}{'bound':>14}{'gap':>10}{'s':>8}")
    rows = []
    for path in arguments.files:
        problem = read_dd(path)
        started = time.perf_counter()
        found = solve(problem, arguments.seconds, _GAP)
        elapsed = time.perf_counter() - started
        size = f"{problem.n_sources}x{problem.n_targets}"
        print(
            f"{path.name[:23]:24}{size:>12}{len(problem.terms.costs):>9}{found.value:>14.5f}"
            f"{found.lower_bound:>14.5f}{found.gap:>10.2e}{elapsed:>8.2f}",
            flush=True,
        )
        other = solve_by_pylibmgm(path)
        if other:
            print(
                f"{'  pylibmgm':45}{other['pylibmgm_energy']:>14.5f}"
                f"{'-':>14}{'-':>10}{other['pylibmgm_seconds']:>8.2f}",
                flush=True,
            )
        row = {"instance": path.name, "energy": found.value, "lower_bound": found.lower_bound}
        rows.append({**row, "seconds": elapsed, "iterations": found.iterations, **other})
    print_json(arguments, rows[0] if len(rows) == 1 else rows)


if __name__ == "__main__":
    main()
