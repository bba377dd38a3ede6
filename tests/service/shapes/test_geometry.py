"""Shapes as they are looked at."""

import gzip
import struct
from collections.abc import Callable
from functools import cached_property
from typing import BinaryIO

import httpx2
import pytest

from broker.store import DEFAULT_KEYS, Shapes, Store
from service.http import ShapeNotFound
from service.shapes.files import get_geometry
from service.standalone import EmbeddedServer
from tests.service.conftest import Api, Json, idle_api, problem, put_shapes, service_over
from tests.worker.figures import blob_file


def test_the_geometry_of_a_shape(http: httpx2.Client, upload: Callable[..., Json]) -> None:
    shape = upload(blob_file(2, seed=70))
    where = f"/v1/shapes/{shape['id']}/geometry"
    answer = http.get(where)
    assert answer.headers["content-encoding"] == "gzip"
    magic, vertices, faces, colors = struct.unpack_from("<8s3I", answer.content)
    assert (magic, vertices, faces, colors) == (b"isogeom1", 162, 320, 0)
    assert len(answer.content) == 56 + 16 * vertices + 12 * faces
    plain = http.get(where, headers={"Accept-Encoding": "identity"})
    assert "content-encoding" not in plain.headers
    assert plain.content == answer.content
    assert plain.headers["vary"] == answer.headers["vary"] == "Accept-Encoding"


def test_unchanged_geometry_is_not_sent_again(
    http: httpx2.Client, upload: Callable[..., Json]
) -> None:
    data = blob_file(2, seed=71)
    where = f"/v1/shapes/{upload(data)['id']}/geometry"
    etag = http.get(where).headers["etag"]
    # A strong one would have to differ from that of the body without gzip.
    assert etag.startswith('W/"')
    strong = etag.removeprefix("W/")
    for has in (etag, strong, f'"other", {etag}', "*"):
        headers = {"If-None-Match": has, "Accept-Encoding": "identity"}
        answer = http.get(where, headers=headers)
        assert (answer.status_code, answer.content) == (304, b"")
        assert answer.headers["etag"] == etag
    assert http.get(where, headers={"If-None-Match": '"other"'}).status_code == 200
    http.delete(where.removesuffix("/geometry"))
    problem(http.get(where, headers={"If-None-Match": etag}), 404, "shape-not-found")
    # Read anew, it may have come out otherwise.
    upload(data)
    assert http.get(where, headers={"If-None-Match": etag}).status_code == 200


@pytest.mark.parametrize("part", ["mesh", "geometry"])
def test_unchanged_files_extend_the_life_of_their_shape(
    http: httpx2.Client, upload: Callable[..., Json], api: Api, part: str
) -> None:
    shape = upload(blob_file(2, seed=73))["id"]
    etag = http.get(f"/v1/shapes/{shape}/{part}").headers["etag"]
    kept = (DEFAULT_KEYS.shape(shape), DEFAULT_KEYS.shape_mesh(shape))
    for key in kept:
        api.store.client.expire(key, 100)
    answer = http.get(f"/v1/shapes/{shape}/{part}", headers={"If-None-Match": etag})
    assert answer.status_code == 304
    assert all(api.store.client.ttl(key) > 100 for key in kept)


def test_shapes_that_were_stored_without(
    http: httpx2.Client, upload: Callable[..., Json], api: Api
) -> None:
    shape = upload(blob_file(2, seed=72))["id"]
    packed = api.store.shapes.open_geometry(shape)
    api.store.client.delete(DEFAULT_KEYS.shape_geometry(shape))
    assert packed is not None
    with packed:
        assert gzip.decompress(packed.read()).startswith(b"isogeom1")
    problem(http.get(f"/v1/shapes/{shape}/geometry"), 410, "geometry-not-kept")


class DeletedMeanwhile(Shapes):
    """Shapes that somebody else deletes as soon as their record was looked at."""

    def open_geometry(self, shape_id: str) -> BinaryIO | None:
        """Return what is left then."""
        self.delete(shape_id)
        return super().open_geometry(shape_id)


class DeletingStore(Store):
    """A store of such shapes."""

    @cached_property
    def shapes(self) -> DeletedMeanwhile:
        """Those shapes."""
        return self._part(DeletedMeanwhile)


def test_a_shape_that_is_deleted_meanwhile_is_not_there(server: EmbeddedServer) -> None:
    with idle_api(server) as api:
        name, _ = put_shapes(api)
        store = DeletingStore.over(api.store.client, api.store.settings, retry_seconds=1)
        with pytest.raises(ShapeNotFound):
            get_geometry(name, service_over(store))
