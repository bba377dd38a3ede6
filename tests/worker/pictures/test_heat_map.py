"""The colour bar of a heat map, and its scale, which the page shares."""

import itertools
import re

import numpy as np
import pytest
from isomatch._figures import heat_map as client_heat_map
from isomatch._figures.colors import COLOR_SCALE
from matplotlib import colormaps
from matplotlib.colors import PowerNorm

from service.page import STATIC
from worker.pictures import heat_map
from worker.pictures.heat_map import COLORMAP, LIGHT, separate_ticks


@pytest.mark.parametrize("greatest", [0.0505, 0.051, 0.06, 0.999, 7.0])
def test_labels_of_a_bar_do_not_touch(greatest: float) -> None:
    norm = PowerNorm(0.5, 0.0, greatest, clip=True)
    ticks = [*np.linspace(0.0, 1.2 * greatest, 13), 1.21 * greatest, 1.3 * greatest]
    kept = separate_ticks([*ticks[:5], ticks[5] * 0.999, *ticks[5:]], norm)
    assert kept
    assert set(kept) <= set(ticks) | {ticks[5] * 0.999}
    assert 0.0 <= kept[0] < kept[-1] <= greatest
    places = [float(norm(tick)) for tick in kept]
    assert all(after - before > 0.03 for before, after in itertools.pairwise(places))


def test_ticks_that_are_apart_all_stay() -> None:
    assert separate_ticks([0.0, 0.25, 0.5, 1.0], PowerNorm(1.0, 0.0, 1.0)) == [0.0, 0.25, 0.5, 1.0]


def test_page_and_client_have_the_same_scale() -> None:
    script = (STATIC / "heat_map.js").read_text()
    names = "COLORSCALE|UPPER_QUANTILE|LEAST_CLIPPED|MOST_NUMBERED|MOST_NAMES"
    declared = dict(re.findall(rf"const ({names}) = \"?([\w.]+)\"?;", script))
    assert declared["COLORSCALE"].lower() == COLORMAP
    assert COLOR_SCALE.lower() == COLORMAP
    for name in ("UPPER_QUANTILE", "LEAST_CLIPPED", "MOST_NUMBERED", "MOST_NAMES"):
        assert float(declared[name]) == getattr(heat_map, name)
        assert getattr(client_heat_map, name) == getattr(heat_map, name)


def test_numbers_in_cells_are_legible() -> None:
    """Contrast as WCAG defines it, at least 4.5 (AA)."""
    shares = np.linspace(0.0, 1.0, 1001)
    srgb = colormaps[COLORMAP](shares)[:, :3]
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    luminance = linear @ [0.2126, 0.7152, 0.0722]
    contrast = np.where(shares < LIGHT, 1.05 / (luminance + 0.05), (luminance + 0.05) / 0.05)
    assert contrast.min() >= 4.5


@pytest.mark.parametrize(("pairs", "clipped"), [(1, False), (49, False), (50, True), (91, True)])
def test_scales_are_clipped_where_there_are_many_pairs(pairs: int, clipped: bool) -> None:
    values = np.random.default_rng(pairs).permutation(np.arange(1.0, pairs + 1.0))
    end = heat_map.scale_end(values)
    assert (end < pairs) is clipped
    assert np.mean(values <= end) >= heat_map.UPPER_QUANTILE - 1.0 / pairs
    assert client_heat_map.scale_end(values) == end
    assert heat_map.scale_end(0.0 * values) == client_heat_map.scale_end(0.0 * values) == 1.0
