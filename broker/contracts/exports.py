"""Exports: the results of which jobs are written to files of which formats."""

from broker.contracts.jobs import MatchPayload, Payload, TransferPayload
from broker.contracts.prototypes import is_prototype
from broker.contracts.transfers import LANDMARKS, TEXTURE, UV


def exports_of(payload: Payload) -> tuple[str, ...]:
    """Formats of files that the result of a job is written to, besides arrays and a picture."""
    return tuple(one for one in payload.kind.exports if export_refusal(payload, one) is None)


def export_refusal(payload: Payload, file_type: str) -> str | None:
    """Why the result of a job cannot have a format of its kind; None if it can.

    Parameters
    ----------
    payload
        Of the job.
    file_type
        One of the `exports` of its kind.
    """
    if isinstance(payload, MatchPayload):
        if file_type == "csv" or (payload.parameters.dense and not is_prototype(payload.source)):
            return None
        shown = f"{file_type.upper()} shows a map of all vertices between two shapes"
        return f"{shown}; match again with `dense`"
    if isinstance(payload, TransferPayload):
        if payload.what == LANDMARKS and file_type != "csv":
            return "landmarks are written to CSV and NPZ"
        if payload.what == UV and file_type == "ply":
            return "PLY has no texture coordinates here; choose GLB or OBJ"
        if payload.what not in (TEXTURE, UV) and file_type == "zip":
            return f"zip is OBJ with images, and {payload.what} have none; choose OBJ or another"
    return None
