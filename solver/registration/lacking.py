"""What of a surface another lacks: what has no partner there, by a registration of both.

A point's partner is its image, if that lies inside the other surface, and its own image is near the
point. Where a surface is cut off, its boundary may be nearest to what is missing.
"""

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.control import Control
from solver.mesh import TriangleMesh
from solver.registration.choice import FINE, Task, choose, mapped
from solver.registration.glued import OpenedCandidate
from solver.registration.opening import Opening
from solver.registration.reduction import FEW_VERTICES, ReducedTask, reduction
from solver.registration.refinement import RefinedCandidate, refine_on_few
from solver.registration.surface_map import points_in_triangles
from solver.shape import Shape

RETURN_DISTANCE = 0.03
"""Distance over √area within which the image of a point's image is near it: of parts, between 0.02
and 0.05, the F1 score of vertices without a partner changes by two hundredths."""


def inside(
    mesh: TriangleMesh, on_boundary: BoolArray, faces: IntArray, barycentric: FloatArray
) -> BoolArray:
    """(N,) points on a mesh that are not on its boundary.

    Parameters
    ----------
    mesh
        V vertices.
    on_boundary
        (V,) those on its boundary.
    faces, barycentric
        (N,) triangles and (N, 3) coordinates in them.
    """
    within: FloatArray = (barycentric * ~on_boundary[mesh.faces[faces]]).sum(axis=1)
    return np.asarray(within > 0.0)


def share_lacking(
    shapes: tuple[Shape, Shape], opened: OpenedCandidate, of_source: bool, control: Control
) -> float:
    """Share of the area of one shape that the other lacks, by the refinement on few vertices.

    The one that may be lacking something is bent: what has no partner keeps its shape then, and its
    images are those of something else. Bent itself, a part is stretched over what it lacks.

    Parameters
    ----------
    shapes
        X and Y.
    opened
        A candidate of them. Boundaries of what is opened where parts touch are none of the shapes.
    of_source
        Whether the share is that of X, which Y lacks.
    control
        May cancel; past its deadline, less is refined.

    Raises
    ------
    Cancelled
        Through `control`.
    MeshError
        The Laplacian of the shape that is bent cannot be factored.
    """
    found = opened.on_few(control)
    here, there = (
        _few_on_cut(shape, opening) for shape, opening in zip(shapes, opened.openings, strict=True)
    )
    if not of_source:
        found, here, there = _turned(found, control), there, here
    surface, target = found.displaced.source, found.displaced.target
    forward, back = found.forward[1:], found.back[1:]
    positions = surface.mesh.vertices
    returned = points_in_triangles(points_in_triangles(positions, surface, *back), target, *forward)
    far = np.linalg.norm(returned - positions, axis=1) >= RETURN_DISTANCE
    beyond = ~here & ~inside(target.mesh, there, *forward)
    return surface.share_of_area(far | beyond)


def _few_on_cut(shape: Shape, opening: Opening) -> BoolArray:
    """Which of the few vertices that are left of an opened shape lie where it may be cut off.

    None of a point cloud: its surface has gaps where points are too sparse, which are no boundary.
    """
    few = reduction(opening.shape, FEW_VERTICES)
    if shape.mesh.is_cloud:
        return np.zeros(few.shape.n_vertices, dtype=np.bool_)
    of_shape = shape.mesh.on_cut[opening.vertices[few.vertices]]
    return np.asarray(few.shape.mesh.on_boundary & of_shape)


def _turned(found: RefinedCandidate, control: Control) -> RefinedCandidate:
    """Bend the target onto the source, by the same maps."""
    ours, theirs = found.displaced.source, found.displaced.target
    task = Task.of_surfaces(theirs, ours)
    task = task.reflected() if found.displaced.reflected else task
    turned = choose(task, mapped(task, found.back[0], found.images), FINE, control)[0]
    return refine_on_few(ReducedTask.entire(task), turned, control)
