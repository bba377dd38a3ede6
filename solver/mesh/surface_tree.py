"""Nearest points of a triangulated surface: a tree of bounding boxes."""

from typing import NamedTuple

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.kernel import kernel
from solver.mesh.nearest_points import nearest_in_triangle
from solver.mesh.normals import face_normals

_LEAF = 4
"""Triangles of a leaf, at most twice as many."""

_TIE = 1e-6
"""Relative difference of squared distances, or distance on a surface of unit area, up to which
triangles are equally near."""

_DEPTH = 64
"""Size of the stack of a search: the tree is at most half as deep."""


class SurfaceTree(NamedTuple):
    """A balanced binary tree of the triangles of a surface.

    Node j of level l holds the triangles ``order[(j F) >> l : ((j + 1) F) >> l]``; its children are
    the nodes 2 j and 2 j + 1 of the next level.

    Parameters
    ----------
    corners
        (F, 3, 3) corners of the triangles.
    normals
        (F, 3) unit normals.
    order
        (F,) triangles in the order of the leaves.
    boxes
        (n, 2, 3) least and greatest coordinates of node 2ˡ − 1 + j.
    depth
        Level of the leaves.
    """

    corners: FloatArray
    normals: FloatArray
    order: IntArray
    boxes: FloatArray
    depth: int

    def distances(self, points: FloatArray) -> FloatArray:
        """(S,) distances of (S, 3) points from the surface, O(log F) each."""
        return _distances(points, self)

    def nearest(self, points: FloatArray) -> tuple[IntArray, FloatArray]:
        """Points of the surface nearest to others, O(log F) each.

        Parameters
        ----------
        points
            (S, 3).

        Returns
        -------
        (S,) triangles, of those that are exactly as near the first, and (S, 3) barycentric
        coordinates, none negative, with sum 1.
        """
        return _nearest(points, self)

    def cosines(self, points: FloatArray, normals: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Cosines of the angles between normals and those of the surface at the nearest points.

        Parameters
        ----------
        points, normals
            (S, 3) and (S, 3).

        Returns
        -------
        (S,) least and (S,) greatest cosines, times the lengths of `normals`: the point nearest may
        lie on an edge, where several triangles are as near.
        """
        return _cosines(points, normals, self)


def surface_tree(vertices: FloatArray, faces: IntArray) -> SurfaceTree:
    """Return the tree of a surface, in O(F log² F).

    Parameters
    ----------
    vertices, faces
        (V, 3) and (F, 3).
    """
    corners = np.ascontiguousarray(vertices[faces])
    normals = face_normals(vertices, faces)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    depth = max(len(faces) // _LEAF, 1).bit_length() - 1
    order = _sorted(corners.mean(axis=1), depth)
    boxes = _boxes(corners, order, depth)
    return SurfaceTree(corners, normals / np.maximum(lengths, 1e-300), order, boxes, depth)


@kernel
def _sorted(centres: FloatArray, depth: int) -> IntArray:
    """Order triangles so that the two halves of each node lie apart along its longest side."""
    count = len(centres)
    order = np.arange(count)
    for level in range(depth):
        for node in range(1 << level):
            first, last = (node * count) >> level, ((node + 1) * count) >> level
            part = order[first:last].copy()
            axis, longest = 0, -1.0
            for d in range(3):
                values = centres[part, d]
                if values.max() - values.min() > longest:
                    axis, longest = d, values.max() - values.min()
            order[first:last] = part[np.argsort(centres[part, axis])]
    return order


@kernel
def _boxes(corners: FloatArray, order: IntArray, depth: int) -> FloatArray:
    count = len(order)
    boxes = np.empty(((2 << depth) - 1, 2, 3))
    for level in range(depth, -1, -1):
        for node in range(1 << level):
            here = (1 << level) - 1 + node
            for d in range(3):
                if level < depth:
                    below = (2 << level) - 1 + 2 * node
                    boxes[here, 0, d] = min(boxes[below, 0, d], boxes[below + 1, 0, d])
                    boxes[here, 1, d] = max(boxes[below, 1, d], boxes[below + 1, 1, d])
                else:
                    boxes[here, 0, d], boxes[here, 1, d] = np.inf, -np.inf
                    for place in range((node * count) >> level, ((node + 1) * count) >> level):
                        for corner in range(3):
                            value = corners[order[place], corner, d]
                            boxes[here, 0, d] = min(boxes[here, 0, d], value)
                            boxes[here, 1, d] = max(boxes[here, 1, d], value)
    return boxes


@kernel
def _distances(points: FloatArray, tree: SurfaceTree) -> FloatArray:
    found = np.empty(len(points))
    for place in range(len(points)):
        x, y, z = points[place]
        found[place] = np.sqrt(nearest_triangles(x, y, z, 0.0, 0.0, 0.0, tree, np.inf)[0])
    return found


@kernel
def _nearest(points: FloatArray, tree: SurfaceTree) -> tuple[IntArray, FloatArray]:
    faces, weights = np.empty(len(points), dtype=np.int64), np.empty((len(points), 3))
    for place in range(len(points)):
        x, y, z = points[place]
        face = nearest_triangles(x, y, z, 0.0, 0.0, 0.0, tree, np.inf)[3]
        _, s, t = nearest_in_triangle((x, y, z), tree.corners[face], 0, 1, 2)
        faces[place] = face
        weights[place] = max(1.0 - s - t, 0.0), s, t
    return faces, weights


@kernel
def _cosines(
    points: FloatArray, normals: FloatArray, tree: SurfaceTree
) -> tuple[FloatArray, FloatArray]:
    least, greatest = np.empty(len(points)), np.empty(len(points))
    for place in range(len(points)):
        x, y, z = points[place]
        u, v, w = normals[place]
        _, low, high, _ = nearest_triangles(x, y, z, u, v, w, tree, np.inf)
        least[place], greatest[place] = low, high
    return least, greatest


@kernel
def nearest_triangles(
    x: float, y: float, z: float, u: float, v: float, w: float, tree: SurfaceTree, bound: float
) -> tuple[float, float, float, int]:
    """Nearest triangles of a point: several, if its nearest point is on an edge.

    Parameters
    ----------
    x, y, z
        The point.
    u, v, w
        A normal.
    tree
        Of the surface.
    bound
        An upper bound of the squared distance.

    Returns
    -------
    The squared distance, the least and greatest inner products of the normals of the nearest
    triangles with (u, v, w), and the first triangle of exactly that distance.
    """
    best, least, greatest = np.inf, 0.0, 0.0
    exact, nearest = np.inf, -1
    bound = bound * (1.0 + _TIE) + _TIE**2
    stack = np.empty(_DEPTH, dtype=np.int64)
    stack[0], size = 0, 1
    while size:
        size -= 1
        node = stack[size]
        if _box_square(x, y, z, tree.boxes, node) > bound:
            continue
        if node < (1 << tree.depth) - 1:
            near, far = 2 * node + 1, 2 * node + 2
            if _box_square(x, y, z, tree.boxes, far) < _box_square(x, y, z, tree.boxes, near):
                near, far = far, near
            stack[size], stack[size + 1] = far, near
            size += 2
            continue
        first, last = _leaf(node, tree)
        for place in range(first, last):
            face = tree.order[place]
            square = max(nearest_in_triangle((x, y, z), tree.corners[face], 0, 1, 2)[0], 0.0)
            if square > bound:
                continue
            if square < exact or (square == exact and face < nearest):
                exact, nearest = square, face
            normal = tree.normals[face]
            product = u * normal[0] + v * normal[1] + w * normal[2]
            if square * (1.0 + _TIE) + _TIE**2 < best:
                best, least, greatest = square, product, product
            elif square <= best * (1.0 + _TIE) + _TIE**2:
                best = min(best, square)
                least, greatest = min(least, product), max(greatest, product)
            bound = min(bound, best * (1.0 + _TIE) + _TIE**2)
    return best, least, greatest, nearest


@kernel
def _leaf(node: int, tree: SurfaceTree) -> tuple[int, int]:
    leaf, count = node - (1 << tree.depth) + 1, len(tree.order)
    return (leaf * count) >> tree.depth, ((leaf + 1) * count) >> tree.depth


@kernel
def _box_square(x: float, y: float, z: float, boxes: FloatArray, node: int) -> float:
    """Square of the distance of a point from a box."""
    a = max(boxes[node, 0, 0] - x, 0.0, x - boxes[node, 1, 0])
    b = max(boxes[node, 0, 1] - y, 0.0, y - boxes[node, 1, 1])
    c = max(boxes[node, 0, 2] - z, 0.0, z - boxes[node, 1, 2])
    return float(a * a + b * b + c * c)
