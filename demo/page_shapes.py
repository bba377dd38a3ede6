"""Generate the sample shapes of the page: ``python -m demo.page_shapes``."""

from pathlib import Path

from demo.figures import write_off
from synthetic import articulated

FOLDER = Path(__file__).resolve().parents[1] / "service" / "page" / "static" / "shapes"
SHAPES = (
    ("human", "standing", 1500),
    ("human", "walking", 1200),
    ("cat", "standing", 1200),
    ("cat", "sitting", 1200),
    ("horse", "standing", 1200),
    ("horse", "galloping", 1200),
)
"""Class, pose and number of vertices; each is triangulated apart."""


def main() -> None:
    """Write the files, with four digits: a tenth of a millimetre."""
    FOLDER.mkdir(exist_ok=True)
    for seed, (category, pose, vertices) in enumerate(SHAPES):
        shape = articulated(category, pose, vertices, seed)
        write_off(FOLDER / f"{category}-{pose}.off", shape, "%.4f")


if __name__ == "__main__":
    main()
