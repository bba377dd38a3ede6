"""Figures of plain arrays, checked by the data they are made of."""

import numpy as np
import pytest
from isomatch._figures import Panel, draw_dissimilarities, draw_panels, position_colors
from isomatch._figures.camera import aligned_view
from isomatch._figures.heat_map import digits
from scipy.spatial.transform import Rotation

from worker.pictures import View, target_view
from worker.pictures.heat_map import digits as as_in_pictures


def test_views_align_corresponding_points() -> None:
    rng = np.random.default_rng(8)
    here = rng.normal(size=(60, 3)) * [1.0, 3.0, 0.4]
    view = np.array([[0.6, 0.0, -0.8], [0.0, -1.0, 0.0], [-0.8, 0.0, -0.6]])
    angle = 0.7
    cosine, sine = np.cos(angle), np.sin(angle)
    rotation = np.array([[cosine, 0.0, sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]])
    there = here @ rotation.T + [5.0, 0.0, 1.0]
    aligned = aligned_view(view, here[:12], there[:12])
    seen, other = (
        (points - points.mean(axis=0)) @ axes.T for points, axes in ((here, view), (there, aligned))
    )
    np.testing.assert_allclose(seen, other, atol=1e-9)
    panels = Panel(here, here[:12], view=view), Panel(there, there[:12])
    figure = draw_panels(panels, "")
    for scene, axes in ((figure.layout.scene, view), (figure.layout.scene2, aligned)):
        eye = np.array([scene.camera.eye[axis] for axis in "xyz"])
        np.testing.assert_allclose(eye / np.linalg.norm(eye), axes[2])
        np.testing.assert_allclose([scene.camera.up[axis] for axis in "xyz"], axes[1])


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("thinness", [1.0, 0.05])
def test_views_are_those_of_pictures(thinness: float, seed: int) -> None:
    """Also where the target's file has another axis up, and its points are not quite the same."""
    rng = np.random.default_rng(seed)
    view = Rotation.random(random_state=rng).as_matrix()
    here = rng.normal(size=(12, 3)) * [thinness, 1.0, thinness]
    turn = rng.choice([0.1, 3.0]) * rng.normal(size=3)
    there = 5.0 * here @ Rotation.from_rotvec(turn).as_matrix().T + [40.0, 0.0, 1.0]
    there += 5.0 * rng.choice([0.0, 0.02, 0.3]) * rng.normal(size=there.shape)
    expected = target_view(View(view), here, there).axes
    np.testing.assert_allclose(aligned_view(view, here, there), expected, atol=1e-9)


def test_fewer_than_three_points_turn_nothing() -> None:
    points = np.random.default_rng(9).normal(size=(2, 3))
    view = np.eye(3)[[0, 2, 1]]
    assert aligned_view(view, points, points[:, [2, 1, 0]]) is view


def test_all_of_a_shape_is_in_sight() -> None:
    points = np.random.default_rng(3).normal(size=(40, 3)) * [0.1, 5.0, 2.0]
    scene = draw_panels([Panel(points)], "").layout.scene
    assert scene.aspectmode == "cube"
    ranges = np.array([scene[f"{axis}axis"].range for axis in "xyz"])
    assert (ranges[:, 0] <= points.min(axis=0)).all()
    assert (ranges[:, 1] >= points.max(axis=0)).all()
    np.testing.assert_allclose(np.ptp(ranges, axis=1), 1.05 * np.ptp(points[:, 1]))


def test_neighbouring_points_have_similar_colours() -> None:
    points = np.random.default_rng(7).normal(size=(50, 3)) * [1.0, 10.0, 0.0]
    colors = position_colors(points, points)
    assert colors.min() >= 0.0
    assert colors.max() <= 1.0
    other = points * 5.0 - 3.0
    np.testing.assert_allclose(colors, position_colors(other, other), atol=1e-12)
    np.testing.assert_allclose(colors[:7], position_colors(points[:7], points))
    assert position_colors(points[:0], points).shape == (0, 3)


def test_titles_and_names_are_plain_text() -> None:
    """Neither HTML nor formulas."""
    figure = draw_panels([Panel(np.eye(3), caption="<b>a$x_{$.off")], "a & b\n$y$")
    assert figure.layout.annotations[0].text == "&lt;b&gt;a&#36;x_{&#36;.off"
    assert figure.layout.title.text == "a &amp; b<br>&#36;y&#36;"
    map_ = draw_dissimilarities(np.zeros((2, 2)), ["<i>", "b"], None, "<u>")
    assert map_.layout.xaxis.ticktext == ("&lt;i&gt;", "b")
    assert map_.layout.title.text == "&lt;u&gt;"


def test_figures_are_written_as_pages() -> None:
    page = draw_panels([Panel(np.eye(3), np.eye(3))], "three points").to_html(
        include_plotlyjs=False
    )
    assert "three points" in page
    assert "scatter3d" in page


def test_classes_are_separated() -> None:
    figure = draw_dissimilarities(np.zeros((3, 3)), ["one", "b", "two"], ["z", "b", "z"], "")
    # Classes are in the order of their first shapes, as in pictures and on the page.
    assert figure.layout.xaxis.ticktext == ("one", "two", "b")
    borders = [(shape.x0, shape.y0) for shape in figure.layout.shapes]
    assert borders == [(0, 1.5), (1.5, 0)]
    many = [str(number) for number in range(41)]
    assert draw_dissimilarities(np.zeros((41, 41)), many, None, "").layout.xaxis.ticktext is None


@pytest.mark.parametrize(
    ("shapes", "last", "written"), [(3, "7", True), (12, "≥ 2", True), (13, "≥ 2", False)]
)
def test_numbers_are_written_and_the_end_of_a_clipped_scale_is_marked(
    shapes: int, last: str, written: bool
) -> None:
    matrix = np.full((shapes, shapes), 2.0)
    np.fill_diagonal(matrix, 0.0)
    matrix[0, 1] = matrix[1, 0] = 7.0
    matrix[0, 2] = matrix[2, 0] = np.nan
    (cells,) = draw_dissimilarities(matrix, ["a"] * shapes, None, "").data
    assert cells.colorbar.ticktext[-1] == last
    assert cells.colorbar.tickvals[-1] == pytest.approx(cells.zmax)
    assert (cells.text is not None) is written
    if written:
        assert list(cells.text[0][:3]) == ["0", "7", ""]


@pytest.mark.parametrize("significant", [2, 3, 4])
def test_numbers_are_written_as_in_pictures(significant: int) -> None:
    values = [0.0, 2.84e-5, 9.999e-4, 1e-3, 0.5, 12.5, 99_999.0, 123_456.0, 2.5e200]
    written = [digits(value, significant) for value in values]
    assert written == [as_in_pictures(value, significant) for value in values]


def test_small_numbers_have_exponents_of_few_digits() -> None:
    matrix = np.full((3, 3), 2.84e-5)
    matrix[0, 2] = matrix[2, 0] = np.nan
    (cells,) = draw_dissimilarities(matrix, ["a", "b", "c"], None, "").data
    assert list(cells.text[0]) == ["2.8e-5", "2.8e-5", ""]
    assert cells.colorbar.ticktext[-1] == "2.84e-5"
    assert cells.hovertext[0][1] == "a, b: 2.840e-5"
    assert "hovertext" in cells.hovertemplate
