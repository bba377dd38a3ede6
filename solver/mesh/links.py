"""Links: pairs of vertices over the gaps between components, which make them one surface.

Scans are often in parts: a body cut at the waist, a skull and its jaw. What is computed along a
surface (geodesics, the Laplace-Beltrami operator, descents from vertex to vertex) needs it
connected. Links connect the components where they are nearest; two that are both cut off, from rim
to rim, because there the surface goes on: a forearm may lie against a hip. They are edges without
faces: they have no area and no normal, and nothing that is drawn or written has them.
"""

import numpy as np
from scipy.spatial import KDTree

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.mesh.edges import components_of


def component_links(
    vertices: FloatArray, component: IntArray, edge: float, rim: BoolArray
) -> IntArray:
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
    rim
        (V,) whether the component may be cut off at a vertex. Two that have such vertices are
        linked there alone.

    Returns
    -------
    (L, 2) int64 vertices of different components, smaller vertex first, each pair once. With C
    components O(log² C · V log V).
    """
    is_cut = np.zeros(int(component.max(initial=0)) + 1, dtype=np.bool_)
    is_cut[component[rim]] = True
    closed = ~is_cut[component]
    group, links = component, np.zeros((0, 2), dtype=np.int64)
    while group.max(initial=0) > 0:
        nearest, gaps = _nearest_elsewhere(vertices, group, rim, closed)
        least = np.full(int(group.max()) + 1, np.inf)
        np.minimum.at(least, group, gaps)
        mutual = nearest[nearest] == np.arange(len(nearest))
        near = np.flatnonzero(gaps <= least[group] + np.where(mutual, edge, 0.0))
        found = np.sort(np.stack([near, nearest[near]], axis=1), axis=1)
        links = np.unique(np.concatenate([links, found]), axis=0)
        group = components_of(group[found], len(least))[group]
    return links


def _nearest_elsewhere(
    vertices: FloatArray, group: IntArray, rim: BoolArray, closed: BoolArray
) -> tuple[IntArray, FloatArray]:
    """Nearest vertex of another group to which each may be linked, and its distance.

    Two numbers that differ, differ in a bit: so a search between the vertices whose number has
    this bit and those whose number has it not, for every bit, sees all pairs of groups. Vertices
    off the rim of a component that is cut may be linked to closed components alone.
    """
    nearest = np.full(len(vertices), -1, dtype=np.int64)
    gaps = np.full(len(vertices), np.inf)
    for bit in range(int(group.max()).bit_length()):
        is_set = (group >> bit & 1).astype(np.bool_)
        for side in (is_set, ~is_set):
            for ours, theirs in ((rim, rim), (closed, ~side), (~closed, closed)):
                mine, others = np.flatnonzero(side & ours), np.flatnonzero(~side & theirs)
                if not (len(mine) and len(others)):
                    continue
                found = KDTree(vertices[others]).query(vertices[mine])
                distances, places = (np.asarray(one) for one in found)
                nearer = distances < gaps[mine]
                gaps[mine[nearer]] = distances[nearer]
                nearest[mine[nearer]] = others[places[nearer]]
    return nearest, gaps
