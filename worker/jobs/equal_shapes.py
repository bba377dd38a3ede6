"""Shapes that other tenants made of the same bytes: a mesh is repaired once for all tenants.

The copy is a shape of its own, with bytes of its own: what one tenant does to its shape, another
does not notice.
"""

import hashlib
from dataclasses import dataclass

from broker.blobs import BlobLost, NotMigrated
from broker.contracts import ShapeRecord, ValidationPayload
from broker.store import NewerRecord, Store


@dataclass(frozen=True)
class ValidatedShape:
    """What an upload has become.

    Parameters
    ----------
    record
        Its record.
    mesh
        The repaired mesh, npz.
    geometry
        The geometry that the page draws, gzip.
    """

    record: ShapeRecord
    mesh: bytes
    geometry: bytes


def equal_shape(payload: ValidationPayload, data: bytes, store: Store) -> ValidatedShape | None:
    """Return what an equal upload of another tenant has become, None if there is none.

    Parameters
    ----------
    payload
        The upload.
    data
        Its bytes.
    store
        The store of the tenant that has sent it.
    """
    digest = hashlib.sha256(data).hexdigest()
    for tenant in store.tenants():
        if tenant == store.keys.tenant:
            continue
        other = store.of(tenant)
        try:
            record = other.shapes.get(payload.shape)
            if record is None or record.file_type != payload.file_type or _is_early(record):
                continue
            # The id is a part of the digest, and could be forged.
            upload = other.blobs.reference(other.keys.shape_upload(payload.shape))
            if upload is None or upload.digest != digest:
                continue
            # Read past the other tenant's subject, which would prolong the life of its shape.
            mesh = other.blobs.get(other.keys.shape_mesh(payload.shape))
            geometry = other.blobs.get(other.keys.shape_geometry(payload.shape))
        except (BlobLost, NotMigrated, NewerRecord):
            continue
        if mesh is not None and geometry is not None:
            return ValidatedShape(record, mesh, geometry)
    return None


def _is_early(record: ShapeRecord) -> bool:
    """Whether an earlier version made a shape: its record would show that it is a copy."""
    return record.file_vertices is None
