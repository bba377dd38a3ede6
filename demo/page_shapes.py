"""Generate the sample shapes of the page: ``python -m demo.page_shapes``."""

from pathlib import Path

import numpy as np

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
        with (FOLDER / f"{category}-{pose}.off").open("w") as file:
            file.write(f"OFF\n{len(shape.vertices)} {len(shape.faces)} 0\n")
            np.savetxt(file, shape.vertices, fmt="%.4f")
            np.savetxt(file, np.insert(shape.faces, 0, 3, axis=1), fmt="%d")


if __name__ == "__main__":
    main()
