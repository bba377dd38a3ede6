"""Names in pictures."""

import pytest

from worker.pictures.canvas import new_figure, png, shortened


@pytest.mark.parametrize("name", ["\u65e5\u672c.off", "cat \U0001f98b.off", "$x^2$ \x07 \u0645"])
def test_names_of_any_letters_are_drawn(name: str) -> None:
    """The font has not all of them, of which it would warn; warnings fail tests."""
    figure = new_figure((2.0, 1.0))
    figure.text(0.1, 0.5, shortened(name, 40), parse_math=False)
    assert png(figure).startswith(b"\x89PNG")
    assert len(shortened(name, 40)) == len(name)
    assert len(shortened(9 * name, 40)) == 40
