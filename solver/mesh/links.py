"""Links: pairs of vertices over the gaps between components, which make them one surface.

Scans are often in parts: a body cut at the waist, a skull and its jaw. What is computed along a
surface (geodesics, the Laplace-Beltrami operator, descents from vertex to vertex) needs it
connected. Links connect the components where they are nearest. They are edges without faces: they
have no area and no normal, and nothing that is drawn or written has them.
"""

import numpy as np
from scipy.spatial import KDTree

from solver.arrays import FloatArray, IntArray
from solver.mesh.edges import components_of


def component_links(vertices: FloatArray, component: IntArray, edge: float) -> IntArray:
    """Link components so that all are connected, by Borůvka's algorithm (1926).

    In every round each group of linked components is linked to the nearest one, and not in a
    single point: wherever two vertices are nearest to each other and the gap is wider by an edge at
    most, so that a surface that was cut is closed along the cut. The shortest links are a minimum
    spanning tree of the components, with the gaps between them as lengths.

    Parameters
    ----------
    vertices
        (V, 3).
    component
        (V,) component of each vertex, numbered from 0.
    edge
        Mean length of an edge.

    Returns
    -------
    (L, 2) int64 vertices of different components, smaller vertex first, each pair once. With C
    components O(log² C · V log V).
    """
    group, links = component, np.zeros((0, 2), dtype=np.int64)
    while group.max(initial=0) > 0:
        nearest, gaps = _nearest_elsewhere(vertices, group)
        least = np.full(int(group.max()) + 1, np.inf)
        np.minimum.at(least, group, gaps)
        mutual = nearest[nearest] == np.arange(len(nearest))
        rim = np.flatnonzero(gaps <= least[group] + np.where(mutual, edge, 0.0))
        found = np.sort(np.stack([rim, nearest[rim]], axis=1), axis=1)
        links = np.unique(np.concatenate([links, found]), axis=0)
        group = components_of(group[found], len(least))[group]
    return links


def _nearest_elsewhere(vertices: FloatArray, group: IntArray) -> tuple[IntArray, FloatArray]:
    """Nearest vertex of another group for each vertex, and its distance.

    Two numbers that differ, differ in a bit: so a search between the vertices whose number has
    this bit and those whose number has it not, for every bit, sees all pairs of groups.
    """
    nearest = np.full(len(vertices), -1, dtype=np.int64)
    gaps = np.full(len(vertices), np.inf)
    for bit in range(int(group.max()).bit_length()):
        is_set = (group >> bit & 1).astype(np.bool_)
        sides = np.flatnonzero(is_set), np.flatnonzero(~is_set)
        for mine, theirs in (sides, sides[::-1]):
            found = KDTree(vertices[theirs]).query(vertices[mine])
            distances, places = (np.asarray(one) for one in found)
            nearer = distances < gaps[mine]
            gaps[mine[nearer]] = distances[nearer]
            nearest[mine[nearer]] = theirs[places[nearer]]
    return nearest, gaps
