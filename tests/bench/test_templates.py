"""Quality of registered templates, summed up."""

from bench.templates import TemplateQuality, figures


def test_figures_tell_the_worst_and_the_share_without_flips() -> None:
    good = TemplateQuality(0.0, 0.001, 0, 100, 0.001, 1.0, 0.9)
    bad = TemplateQuality(0.002, 0.004, 6, 100, 0.003, 3.0, 0.5)
    found = figures([good, bad])
    assert found["max"] == 0.004
    assert found["without_flips"] == 0.5
    assert (found["flipped"], found["most_flipped"]) == (3.0, 6.0)
    assert found["mean"] == 0.001
