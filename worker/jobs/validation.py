"""Validation of an uploaded mesh: it is read, repaired, measured and stored as a shape."""

from broker.contracts import JobRecord, ShapeRecord, ValidationPayload
from solver.mesh import TriangleMesh, read_mesh
from worker.jobs.context import JobContext
from worker.jobs.meshes import mesh_to_bytes
from worker.jobs.uploads import stored_once
from worker.pictures import packed_geometry, source_view


def validate_shape(payload: ValidationPayload, context: JobContext) -> None:
    """Store the shape of a job's upload.

    Raises
    ------
    MeshError
        The upload is not a usable mesh.
    UploadGone
        The upload has expired.
    """
    store, job, control = context.store, context.record, context.reporter.control()
    with stored_once(store.shapes, payload.shape):
        data = store.uploads.candidate(payload.shape, payload.file_type, job.id)
        control.report("reading the mesh", 0.0)
        # Also if another tenant has the same: that it took less time would tell.
        mesh = read_mesh(data, payload.file_type)
        control.report("measuring the mesh", 0.5)
        record = _record(payload, job, mesh, len(data))
        stored = mesh_to_bytes(mesh), packed_geometry(mesh)
        store.shapes.accept(record, data, *stored, job.id)


def _record(
    payload: ValidationPayload, job: JobRecord, mesh: TriangleMesh, size: int
) -> ShapeRecord:
    vertices, faces = mesh.file_rows or (None, None)
    return ShapeRecord(
        id=payload.shape,
        name=payload.name,
        file_type=payload.file_type,
        bytes=size,
        kind="points" if mesh.is_cloud else "mesh",
        vertices=mesh.n_vertices,
        faces=mesh.n_faces,
        file_vertices=vertices,
        file_faces=faces,
        area=mesh.area,
        components=mesh.components,
        closed=mesh.closed,
        has_colors=mesh.colors is not None,
        view=source_view(mesh.vertices, mesh.faces).rows(),
        warnings=mesh.warnings,
        created=job.created,
    )
