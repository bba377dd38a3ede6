"""Matches of two figures with ground truth through the whole stack."""

import io
import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import isomatch
import numpy as np
import pytest
from PIL import Image

from demo.figures import Figures, generate, write_off
from demo.stack import Stack
from synthetic import ASYMMETRIC_HUMAN

VERTICES = 2000


@pytest.fixture
def client(url: str) -> Iterator[isomatch.Client]:
    with isomatch.Client(url) as client:
        yield client


@pytest.fixture(scope="module")
def symmetric() -> Figures:
    return generate(VERTICES)


@pytest.fixture(scope="module")
def asymmetric() -> Figures:
    return generate(VERTICES, ASYMMETRIC_HUMAN)


def uploaded(
    client: isomatch.Client, figures: Figures, folder: Path
) -> tuple[isomatch.Shape, isomatch.Shape]:
    paths = folder / "source.off", folder / "target.off"
    for path, shape in zip(paths, (figures.source, figures.target), strict=True):
        write_off(path, shape)
    return client.upload(paths[0]), client.upload(paths[1])


def numbers(document: Any) -> Iterator[float]:
    if isinstance(document, dict):
        for value in document.values():
            yield from numbers(value)
    elif isinstance(document, list):
        for value in document:
            yield from numbers(value)
    elif isinstance(document, int | float):
        yield document


def test_a_symmetric_figure(client: isomatch.Client, symmetric: Figures, tmp_path: Path) -> None:
    shapes = uploaded(client, symmetric, tmp_path)
    job = client.match(*shapes, points=32)
    match = job.result(timeout=500)
    direct, mirrored = symmetric.errors(match.pairs)
    assert len(match.pairs) == 32
    assert min(direct.mean(), mirrored.mean()) < 0.05
    assert match.levels[0].certified
    assert match.levels[0].gap <= 1e-4
    assert [level.points for level in match.levels] == [8, 8, 16, 32]
    for level in match.levels:
        assert level.lower_bound <= level.energy + 1e-9
    assert match.lower_bound <= match.energy + 1e-9
    assert match.gromov_hausdorff == pytest.approx(match.distortion.linf / 2)
    assert all(math.isfinite(value) for value in numbers(json.loads(match.to_json())))

    picture = Image.open(io.BytesIO(job.picture()))
    assert picture.format == "PNG"
    assert picture.width >= 600
    assert picture.height >= 300
    colors = picture.convert("RGB").getcolors(maxcolors=2**24)
    assert colors is not None
    assert len(colors) > 50


def test_an_asymmetric_figure_is_not_mirrored(
    client: isomatch.Client, asymmetric: Figures, tmp_path: Path
) -> None:
    match = client.match(*uploaded(client, asymmetric, tmp_path), points=32).result(timeout=500)
    direct, mirrored = asymmetric.errors(match.pairs)
    assert direct.mean() < 0.05
    assert direct.mean() < mirrored.mean()


def test_the_same_request_has_the_same_answer(
    client: isomatch.Client, symmetric: Figures, tmp_path: Path
) -> None:
    shapes = uploaded(client, symmetric, tmp_path)
    first = client.match(*shapes, points=16).result()
    second = client.match(*shapes, points=16).result()
    np.testing.assert_array_equal(first.pairs, second.pairs)
    assert first.energy == second.energy


def test_spectra_are_computed_once(
    stack: Stack, client: isomatch.Client, asymmetric: Figures, tmp_path: Path
) -> None:
    def computed() -> int:
        return stack.log.read_text().count("spectrum computed")

    shapes = uploaded(client, asymmetric, tmp_path)
    # Eigenpairs no other test asks for: neither spectrum is there yet.
    client.match(*shapes, points=8, eigenpairs=160).result()
    before = computed()
    assert before >= 2
    client.match(*shapes, points=12, eigenpairs=160, beta=2.0).result()
    client.match(shapes[1], shapes[0], points=8, eigenpairs=160).result()
    assert computed() == before
    client.match(*shapes, points=8, eigenpairs=161).result()
    assert computed() == before + 2
