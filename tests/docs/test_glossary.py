"""The glossary names modules that exist, and every package of the solver."""

import re

from demo.stack import ROOT

ROWS = re.findall(r"(?m)^\| (?!term|---)(.+?) \|$", (ROOT / "docs" / "glossary.md").read_text())
CELLS = [re.split(r"\s*\|\s*", row) for row in ROWS]
PLACES = {cells[0]: re.findall(r"`([\w/.]+)`", cells[3]) for cells in CELLS}


def test_every_term_names_a_module_that_exists() -> None:
    assert len(PLACES) == len(ROWS) > 30
    for term, places in PLACES.items():
        assert places, term
        for place in places:
            assert (ROOT / place).exists(), f"{term}: {place}"


def test_every_room_of_the_solver_has_a_term() -> None:
    rooms = {path.name for path in (ROOT / "solver").iterdir() if (path / "__init__.py").exists()}
    named = {place for places in PLACES.values() for place in places}
    assert rooms == {place.split("/")[1] for place in named if place.startswith("solver/")}
