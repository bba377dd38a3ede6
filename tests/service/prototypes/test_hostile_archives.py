"""Hostile uploads of prototypes are refused with the reason and leave nothing behind."""

import hashlib
import io
import json
import zipfile
from collections.abc import Callable
from typing import Any

import httpx2
import numpy as np
import pytest

from tests.service.conftest import Api, Json, problem
from tests.service.prototypes.test_prototypes import SHARED, learn, send
from tests.worker.families import family, member
from tests.workers import nothing_is_left


@pytest.fixture(scope="module")
def archive(http: httpx2.Client, upload: Callable[..., Json]) -> bytes:
    examples = [upload(data)["id"] for data in family(5, first=300)]
    record = learn(http, {"shapes": examples, "name": "sound", **SHARED}).prototype
    return http.get(f"/v1/prototypes/{record.id}/archive").content


def changed(archive: bytes, **arrays: Any) -> bytes:
    """An archive with other arrays in the places of some."""
    with np.load(io.BytesIO(archive), allow_pickle=False) as given:
        kept = {name: given[name] for name in given.files}
    stream = io.BytesIO()
    np.savez_compressed(stream, allow_pickle=True, **{**kept, **arrays})
    return stream.getvalue()


def about(archive: bytes, **entries: Any) -> bytes:
    """An archive with other entries in the description it has of itself."""
    with np.load(io.BytesIO(archive), allow_pickle=False) as given:
        told = json.loads(given["about"].tobytes())
    text = json.dumps({**told, **entries}).encode()
    return changed(archive, about=np.frombuffer(text, dtype=np.uint8))


def bomb() -> bytes:
    """A small archive of a great many zeros."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        header = io.BytesIO()
        shape = (200 * 2**20,)
        np.lib.format.write_array_header_1_0(
            header, {"descr": "|u1", "fortran_order": False, "shape": shape}
        )
        with archive.open("about.npy", "w", force_zip64=True) as member:
            member.write(header.getvalue())
            for _ in range(200):
                member.write(bytes(2**20))
        archive.writestr("positions.npy", bytes(60 * 2**20))
    return stream.getvalue()


def vast() -> bytes:
    """An archive whose header promises more than any memory holds."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        header = io.BytesIO()
        np.lib.format.write_array_header_1_0(
            header, {"descr": "<f8", "fortran_order": False, "shape": (2**45,)}
        )
        archive.writestr("about.npy", header.getvalue())
    return stream.getvalue()


FLAT, AXES = np.zeros((28, 2, 1, 1)), 4
SURFACE = member(0)[1].astype(np.int32)

HOSTILE: dict[str, Callable[[bytes], bytes]] = {
    "nothing": lambda archive: b"",
    "text": lambda archive: b"Dear reader,\nthis is a letter.\n",
    "of a damaged beginning": lambda archive: archive[:2] + b"\1\1" + archive[4:],
    "truncated": lambda archive: archive[: len(archive) // 2],
    "one array": lambda archive: _single(np.zeros(3)),
    "another archive": lambda archive: _archive(a=np.zeros(3)),
    "objects": lambda archive: changed(archive, positions=np.array([{}, []], dtype=object)),
    "a pickle": lambda archive: b"cos\nsystem\n(S'touch /tmp/owned'\ntR.",
    "of whole numbers": lambda archive: changed(archive, positions=np.zeros((8, 3), dtype=int)),
    "of another shape": lambda archive: changed(archive, positions=np.zeros((8, 2))),
    "of other numbers": lambda archive: changed(archive, vertices=np.full(8, -1)),
    "nan": lambda archive: changed(archive, positions=np.full((8, 3), np.nan)),
    "weights": lambda archive: changed(archive, distances0_weights=np.ones((28, 2))),
    "no variance": lambda archive: changed(archive, distances0_covariances=FLAT),
    "hardly any variance": lambda archive: changed(archive, distances0_covariances=FLAT + 1e-320),
    "a newer format": lambda archive: about(archive, version=99),
    "no structures": lambda archive: about(archive, metrics=[]),
    "unknown structures": lambda archive: about(archive, metrics=[{"name": "euclid"}]),
    "too many eigenpairs": lambda archive: about(archive, eigenpairs=100_000),
    "infinite": lambda archive: about(archive, distance_backgrounds=[float("inf")]),
    "deep": lambda archive: changed(archive, about=np.frombuffer(b"[" * 10**6, dtype=np.uint8)),
    "far away": lambda archive: changed(archive, positions=np.full((8, 3), 1e300)),
    "far apart": lambda archive: changed(archive, distances0_means=np.full((28, 2, 1), 1e300)),
    "no surface": lambda archive: about(archive, surfaces=99),
    "surfaces without number": lambda archive: about(archive, surfaces="all"),
    "surface of holes": lambda archive: changed(archive, surface0_faces=SURFACE[:40:3]),
    "surface in pieces": lambda archive: changed(archive, surface0_faces=SURFACE[:0]),
    "surface of strangers": lambda archive: changed(archive, surface0_faces=SURFACE + 162),
    "surface of objects": lambda archive: changed(
        archive, surface0_faces=np.array([{}, []], dtype=object)
    ),
    "surface that is flat": lambda archive: changed(
        archive, surface0_vertices=np.zeros((162, 3), dtype=np.float32)
    ),
    "surface that is nowhere": lambda archive: changed(
        archive, surface0_vertices=np.full((162, 3), np.nan, dtype=np.float32)
    ),
    "surface that is far away": lambda archive: changed(
        archive, surface0_vertices=np.full((162, 3), 1e38, dtype=np.float32)
    ),
    "surface too large": lambda archive: changed(
        archive, surface0_vertices=np.zeros((10**5, 3), dtype=np.float32)
    ),
    "points off the surface": lambda archive: changed(
        archive, surface0_points=np.full(8, 162, dtype=np.int32)
    ),
    "points of another number": lambda archive: changed(
        archive, surface0_points=np.zeros(7, dtype=np.int32)
    ),
    "falling eigenvalues": lambda archive: changed(
        archive, surface0_eigenvalues=np.arange(19.0, 0.0, -1.0)
    ),
    "eigenvalues of nothing": lambda archive: changed(archive, surface0_eigenvalues=np.zeros(19)),
    "of few values": lambda archive: changed(
        archive, descriptors0_centre=np.zeros(2), descriptors0_axes=np.ones((2, AXES))
    ),
    "bomb": lambda archive: bomb(),
    "vast": lambda archive: vast(),
}


def _single(array: Any) -> bytes:
    stream = io.BytesIO()
    np.save(stream, array)
    return stream.getvalue()


def _archive(**arrays: Any) -> bytes:
    stream = io.BytesIO()
    np.savez(stream, **arrays)
    return stream.getvalue()


@pytest.mark.parametrize("what", HOSTILE)
def test_unreadable_archives_are_refused_and_leave_nothing(
    http: httpx2.Client, api: Api, archive: bytes, what: str
) -> None:
    data = HOSTILE[what](archive)
    name = hashlib.sha256(data).hexdigest()[:32]
    document = problem(send(http, data), 422, "unusable-prototype")
    assert len(document["detail"]) > 10
    # Advice of NumPy, which is not for those who upload.
    assert "trust" not in document["detail"]
    assert "pickle" not in document["detail"]
    problem(http.get(f"/v1/prototypes/p-{name}"), 404, "prototype-not-found")
    nothing_is_left(api.store, name)


ODD: dict[str, Callable[[bytes], bytes]] = {
    "in one place": lambda archive: changed(archive, positions=np.zeros((8, 3))),
    "small": lambda archive: changed(archive, positions=np.eye(8, 3) * 1e-300),
    "narrow": lambda archive: changed(archive, distances0_covariances=FLAT + 1e-300),
    "wide": lambda archive: changed(archive, distances0_covariances=FLAT + 1e300),
    "with a flat surface": lambda archive: changed(
        archive, surface0_vertices=(member(300)[0] * [1e-3, 1.0, 1.0]).astype(np.float32)
    ),
    "unreadable": lambda archive: about(archive, warnings=["\x1b[31mred\n", "x" * 10**5]),
}


@pytest.mark.parametrize("what", ODD)
def test_unusual_sound_archives_can_be_matched_and_drawn(
    http: httpx2.Client, upload: Callable[..., Json], archive: bytes, what: str
) -> None:
    target = upload(family(1, first=60)[0])["id"]
    answer = send(http, ODD[what](archive))
    assert answer.status_code == 201, answer.text
    assert all(len(warning) <= 300 for warning in answer.json()["warnings"])
    assert all(warning.isprintable() for warning in answer.json()["warnings"])
    body = {"source": answer.json()["id"], "target": target}
    job = http.post("/v1/matches", json=body).json()
    assert http.get(job["links"]["self"], params={"wait": 60}).json()["state"] == "succeeded"
    result = http.get(job["links"]["result"]).json()
    assert sorted(pair["source"] for pair in result["correspondences"]) == list(range(8))
    assert http.get(job["links"]["picture"]).content.startswith(b"\x89PNG")


def test_after_all_that_a_good_archive_still_works(http: httpx2.Client, archive: bytes) -> None:
    assert send(http, archive).status_code in (200, 201)
