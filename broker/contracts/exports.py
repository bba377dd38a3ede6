"""Exports: the results of which jobs are written to files of which formats."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from broker.contracts.jobs import (
    ConsistentMapsPayload,
    MatchPayload,
    Payload,
    RegistrationPayload,
    TransferPayload,
)
from broker.contracts.prototypes import is_prototype
from broker.contracts.transfers import LANDMARKS, TEXTURE, UV, TransferKind

_TRANSFERS: Final[Mapping[TransferKind, tuple[str, ...]]] = MappingProxyType(
    {
        "scalars": ("csv", "ply", "glb"),
        "vectors": ("csv", "ply", "glb"),
        "colors": ("csv", "ply", "obj", "glb"),
        "labels": ("csv", "ply", "obj", "glb"),
        "skinning": ("csv", "ply", "glb"),
        LANDMARKS: ("csv",),
        TEXTURE: ("csv", "ply", "obj", "glb", "zip"),
        UV: ("csv", "obj", "glb", "zip"),
    }
)
"""Formats that hold what a transfer carries, besides NPZ."""


def exports_of(payload: Payload) -> tuple[str, ...]:
    """Formats of files that the result of a job is written to, besides arrays and a picture."""
    return tuple(one for one in payload.kind.exports if export_refusal(payload, one) is None)


def registered_formats(payload: Payload) -> tuple[str, ...]:
    """Formats of files of the registered templates of a result: one surface on another."""
    if not isinstance(payload, MatchPayload | RegistrationPayload):
        return ()
    return tuple(one for one in exports_of(payload) if one != "csv")


def maps_vertices(payload: Payload) -> bool:
    """Whether the result of a job has maps of all vertices between two shapes."""
    dense = isinstance(payload, MatchPayload) and export_refusal(payload, "ply") is None
    return dense or isinstance(payload, ConsistentMapsPayload)


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
        return (
            f"{file_type.upper()} shows a map of all vertices between two shapes, which the match"
            " has not; match again with `dense`"
        )
    if isinstance(payload, TransferPayload) and file_type not in _TRANSFERS[payload.what]:
        others = ", ".join(("NPZ", *map(str.upper, _TRANSFERS[payload.what])))
        return f"{file_type.upper()} cannot hold {payload.what}; choose one of {others}"
    return None
