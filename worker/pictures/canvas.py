"""Figures of fixed resolution, their colours, and PNG files of them."""

from functools import cache
from io import BytesIO
from typing import Final

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, get_font
from matplotlib.ft2font import FT2Font

INK: Final = "#2b2f36"
"""Colour of titles and names."""

FAINT: Final = "#6b7280"
"""Colour of subtitles, labels and skeletons."""

_DOTS_PER_INCH: Final = 140

_BOX: Final = "\N{WHITE SQUARE}"


def new_figure(inches: tuple[float, float]) -> Figure:
    """Return an empty figure of a size, width and height, in inches."""
    return Figure(figsize=inches, dpi=_DOTS_PER_INCH, facecolor="white")


def png(figure: Figure) -> bytes:
    """Return a figure as PNG, the same bytes for the same figure."""
    buffer = BytesIO()
    canvas = FigureCanvasAgg(figure)
    canvas.print_figure(buffer, format="png", dpi=_DOTS_PER_INCH, metadata={"Software": "isomatch"})
    return buffer.getvalue()


def shortened(name: str, longest: int) -> str:
    """Return a name of at most `longest` characters, with an ellipsis if it was longer.

    Characters that the font of the pictures does not have, such as Chinese ones, are boxes.
    """
    name = name if len(name) <= longest else name[: longest - 3] + "..."
    known = _font().get_char_index
    return "".join(letter if letter == "\n" or known(ord(letter)) else _BOX for letter in name)


@cache
def _font() -> FT2Font:
    return get_font(findfont(FontProperties()))
