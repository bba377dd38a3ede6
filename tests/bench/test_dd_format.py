"""The reader of published graph matching instances."""

import lzma
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.dd_format import FormatError, parse_dd, read_dd
from solver.labelling import LabellingProblem
from tests.solver.problems import all_solutions, explicit_instance


def written(problem: LabellingProblem, seed: int) -> str:
    """The text of a problem, its lines and numbers in any order."""
    rng = np.random.default_rng(seed)
    numbers = rng.permutation(problem.n_candidates)
    terms = problem.terms
    lines = [f"p {problem.n_sources} {problem.n_targets} {len(numbers)} {len(terms.costs)}"]
    rows = [
        f"a {number} {x} {y} {cost!r}"
        for number, (x, y), cost in zip(
            numbers, problem.candidates, problem.unary.tolist(), strict=True
        )
    ]
    edges = [
        f"e {numbers[b]} {numbers[a]} {cost!r}"
        for a, b, cost in zip(terms.first, terms.second, terms.costs.tolist(), strict=True)
    ]
    return "\n".join([*lines, *rng.permutation(rows), "c a comment", *rng.permutation(edges)])


def test_problems_are_read_as_they_were_written(tmp_path: Path) -> None:
    for seed in range(5):
        problem = explicit_instance(3, 4, seed, share_of_candidates=0.7)
        text = written(problem, seed)
        path = tmp_path / "instance.dd.xz"
        path.write_bytes(lzma.compress(text.encode()))
        again = read_dd(path)
        ours = [energy for energy, _ in all_solutions(problem)]
        np.testing.assert_allclose([energy for energy, _ in all_solutions(again)], ours)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "no problem line"),
        ("p 1 1 1", "line 1: 4 fields"),
        ("p 1 1 0 0\np 1 1 0 0", "line 2: a second"),
        ("p 1 1 1 0", "announces 1 assignments"),
        ("p 1 1 1 0\na 0 0 0 x", "line 2"),
        ("p 1 1 1 0\na 0 0 3 1.0", "do not exist"),
        ("p 1 1 1 0\na 0 0 0 nan", "finite"),
        ("p 1 2 2 0\na 0 0 0 1\na 0 0 1 1", "same number"),
        ("p 1 2 2 0\na 0 0 0 1\na 1 0 0 1", "unique"),
        ("p 2 2 2 1\na 0 0 0 1\na 1 1 1 1\ne 0 7 1", "does not exist"),
        ("p 2 2 2 1\na 0 0 0 1\na 1 1 1 1\ne 0 1", "line 4: 3 fields"),
        ("p 2 2 2 1\na 0 0 0 1\na 1 1 1 1\ne 0 1 inf", "finite"),
        ("p 1 1 0 1\ne 0 1 1", "there is none"),
    ],
)
def test_unsound_files_are_refused(text: str, message: str) -> None:
    with pytest.raises(FormatError, match=message):
        parse_dd(text)


def test_a_file_that_is_cut_off_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "cut.dd.xz"
    path.write_bytes(lzma.compress(b"p 1 1 0 0")[:-8])
    with pytest.raises(FormatError, match=r"cut\.dd\.xz"):
        read_dd(path)


@given(st.lists(st.text("pae 0123456789.-\n", max_size=60), max_size=6).map("\n".join))
def test_any_text_is_a_problem_or_refused(text: str) -> None:
    with suppress(FormatError):
        assert isinstance(parse_dd(text), LabellingProblem)
