"""Faces that are no surface: refused before repair and matching spend minutes on them."""

from solver.errors import MeshError
from solver.mesh.repair.soup import TriangleSoup

_MOST_IRREGULAR = 2.0
"""Most edges without exactly two faces, for each vertex. A surface has at most one: a boundary
edge begins at each vertex of the boundary. Random faces have three edges each."""

_FEW = 10_000
"""Irregular edges that cost nothing, whatever the shape."""

_MOST_COMPONENTS = 20_000
"""Most components that are linked: of 20,000 a spectrum takes 4 s, of 60,000 minutes."""


def checked_surface(soup: TriangleSoup) -> TriangleSoup:
    """Refuse faces that hardly ever meet along an edge in pairs.

    Parameters
    ----------
    soup
        Every vertex belongs to a face; no face occurs twice.

    Returns
    -------
    TriangleSoup
        The same.

    Raises
    ------
    MeshError
        There are more than `_MOST_IRREGULAR` edges for each vertex that have one face, or more
        than two, and many of them.
    """
    edges = soup.edges
    irregular, count = int((edges.counts != 2).sum()), len(soup.vertices)
    if irregular > max(_MOST_IRREGULAR * count, _FEW):
        raise MeshError(
            f"the faces are no surface: {irregular} of {len(edges.ends)} edges do not have exactly"
            f" two faces, which is more than twice the number of vertices, {count}; check that"
            " the numbers of the faces' vertices were written in order"
        )
    return soup


def checked_components(soup: TriangleSoup) -> TriangleSoup:
    """Refuse a soup of very many components.

    Parameters
    ----------
    soup
        Without debris.

    Returns
    -------
    TriangleSoup
        The same.

    Raises
    ------
    MeshError
        There are more than `_MOST_COMPONENTS`.
    """
    if len(soup.faces) <= _MOST_COMPONENTS:
        return soup
    count = int(soup.component_of_face.max()) + 1
    if count > _MOST_COMPONENTS:
        raise MeshError(
            f"the faces are no surface but {count} separate ones of comparable size; at most"
            f" {_MOST_COMPONENTS} are matched as one: join those that belong together, or leave"
            " out the smallest"
        )
    return soup
