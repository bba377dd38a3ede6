"""Warnings of shapes that are registered as wholes, and may not belong to the others."""

from collections.abc import Iterable, Sequence
from typing import Final

from broker.contracts import LIKELY_RIGHT
from solver.matching import Match
from solver.mesh import TriangleMesh

_LONG: Final = 1.0
"""How much longer, over √area, the boundary of a specimen is than the template's where it may be a
part: that of one hole as large as a twelfth of the area."""


_UNLIKE_SIZES: Final = 10.0
"""Ratio of sizes beyond which specimens are rather in different units, as millimetres and metres,
than of different size."""

_MOST: Final = 20
"""Warnings of single shapes that a result has, and names in one of them, at most: with 256 shapes
there may be thousands, among which the others would be lost."""


def named_warnings(warned: Iterable[tuple[str, Iterable[str]]]) -> tuple[str, ...]:
    """Say each of the warnings of single shapes once, with the names of those it is of.

    Parameters
    ----------
    warned
        Names of shapes or pairs, with their warnings.
    """
    names: dict[str, list[str]] = {}
    for name, warnings in warned:
        for warning in dict.fromkeys(warnings):
            names.setdefault(warning, []).append(name)
    said = [f"{_listed(of)}: {warning}" for warning, of in names.items()]
    left = len(said) - _MOST
    more = (f"{left} more warnings of single shapes are left out",) if left > 0 else ()
    return (*said[:_MOST], *more)


def _listed(names: Sequence[str]) -> str:
    left = len(names) - _MOST
    return ", ".join(names[:_MOST]) + (f" and {left} more" if left > 0 else "")


def own_warnings(found: Match, source: TriangleMesh, target: TriangleMesh) -> tuple[str, ...]:
    """Return the warnings of a match but those of its meshes."""
    meshes = {"source": source, "target": target}
    known = {f"{role}: {one}" for role, mesh in meshes.items() for one in mesh.warnings}
    return tuple(one for one in found.warnings if one not in known)


def unlike_sizes(names: Sequence[str], sizes: Sequence[float]) -> tuple[str, ...]:
    """Warn of specimens that are rather in different units than of different size.

    Parameters
    ----------
    names
        Of the registered specimens, one or more.
    sizes
        Their centroid sizes, in the units of their files.
    """
    ascending = sorted(zip(sizes, names, strict=True))
    (least, small), (greatest, large) = ascending[0], ascending[-1]
    if greatest <= _UNLIKE_SIZES * least:
        return ()
    return (
        f"{large!r} is {greatest / least:.3g} times as large as {small!r}: mean and components are"
        " of sizes rather than of shapes; bring all to one unit, or leave size out with `scale`",
    )


def doubtful_specimens(
    names: Sequence[str],
    confidences: Sequence[float | None],
    boundaries: Sequence[float],
    template: float,
) -> tuple[str, ...]:
    """Warn of specimens that may be parts, or matched wrongly.

    Parameters
    ----------
    names
        Of the registered specimens.
    confidences
        Of their matches, None where it is not known.
    boundaries
        Lengths of their boundaries over √area.
    template
        That of the template.
    """
    doubted = [
        f"{name!r} ({confidence:.2f})"
        for name, confidence in zip(names, confidences, strict=True)
        if confidence is not None and confidence <= LIKELY_RIGHT
    ]
    parts = possible_parts(names, boundaries, template)
    warnings = []
    if doubted:
        warnings.append(
            f"matched with a confidence of at most {LIKELY_RIGHT:g}, and yet in the mean and the"
            f" components: {', '.join(doubted)}; look at them, and leave out those that are wrong"
        )
    if parts:
        warnings.append(
            f"with a long boundary, as parts of a surface have: {parts}; the whole template was"
            " put on them, and they are in the mean and the components; leave them out, or fill"
            " their holes"
        )
    return tuple(warnings)


def possible_parts(names: Sequence[str], boundaries: Sequence[float], whole: float) -> str:
    """Name the shapes that may be parts, with the lengths of their boundaries; empty if none is.

    Parameters
    ----------
    names
        Of the shapes.
    boundaries
        Lengths of their boundaries over √area.
    whole
        That of a shape that is no part.
    """
    return ", ".join(
        f"{name!r} ({boundary:.1f} √area)"
        for name, boundary in zip(names, boundaries, strict=True)
        if boundary - whole >= _LONG
    )


def boundary_of(mesh: TriangleMesh) -> float:
    """Length of a surface's boundary over √area, but for small holes; a point cloud has gaps."""
    return 0.0 if mesh.is_cloud else mesh.relative_boundary


def parts_as_wholes(source: TriangleMesh, target: TriangleMesh) -> tuple[str, ...]:
    """Warn of shapes that look like parts, and are matched as wholes."""
    part = possible_parts(("source", "target"), (boundary_of(source), boundary_of(target)), 0.0)
    if not part:
        return ()
    return (
        f'with a long boundary, as parts of a surface have: {part}; `partial` is "none", so that'
        " vertices without a partner have images, too; leave it out to have parts detected",
    )
