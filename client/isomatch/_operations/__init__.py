"""Operations of the API without I/O: requests and the values of their answers, for both clients.

See :mod:`isomatch._http.operation` for the form of an operation.
"""

from isomatch._operations.job import (
    cancel_job,
    follow_job,
    get_job,
    list_jobs,
    start_dissimilarities,
    start_match,
    wait_for_job,
    watch_job,
)
from isomatch._operations.prototype import (
    ArchiveSource,
    delete_prototype,
    download_prototype,
    get_prototype,
    get_prototype_points,
    list_prototypes,
    start_prototype,
    upload_prototype,
)
from isomatch._operations.result import (
    get_drawable,
    get_partial,
    get_picture,
    get_result,
    plot_result,
    save_arrays,
    save_picture,
)
from isomatch._operations.shape import (
    delete_shape,
    get_geometry,
    get_mesh,
    get_shape,
    list_shapes,
    list_structures,
    upload,
)

__all__ = [
    "ArchiveSource",
    "cancel_job",
    "delete_prototype",
    "delete_shape",
    "download_prototype",
    "follow_job",
    "get_drawable",
    "get_geometry",
    "get_job",
    "get_mesh",
    "get_partial",
    "get_picture",
    "get_prototype",
    "get_prototype_points",
    "get_result",
    "get_shape",
    "list_jobs",
    "list_prototypes",
    "list_shapes",
    "list_structures",
    "plot_result",
    "save_arrays",
    "save_picture",
    "start_dissimilarities",
    "start_match",
    "start_prototype",
    "upload",
    "upload_prototype",
    "wait_for_job",
    "watch_job",
]
