"""The fit of the weights of a confidence, where the answer is known."""

from pathlib import Path

import numpy as np
import pytest

from bench.confidence import ConfidentAnswer, load_features, report, save_features
from bench.logistic import fit_logistic, held_out_probability
from bench.varied_pairs import DIFFERENT


def test_one_binary_measure_gives_the_logits_of_the_shares() -> None:
    # 30 of 40 are right where the measure is 0, and 10 of 50 where it is 1.
    measures = np.repeat([0.0, 1.0], [40, 50])[:, None]
    right = np.concatenate([np.arange(40) < 30, np.arange(50) < 10])
    fit = fit_logistic(["doubt"], measures, right, strength=1e-9)
    assert fit.intercept == pytest.approx(np.log(3.0), abs=1e-4)
    assert fit.weights["doubt"] == pytest.approx(np.log(1 / 4) - np.log(3.0), abs=1e-4)
    assert fit.probability(np.array([[0.0], [1.0]])) == pytest.approx([0.75, 0.2], abs=1e-4)


def test_a_balanced_fit_gives_the_odds_of_as_many_right_as_wrong_answers() -> None:
    measures = np.repeat([0.0, 1.0], [40, 50])[:, None]
    right = np.concatenate([np.arange(40) < 30, np.arange(50) < 10])
    fit = fit_logistic(["doubt"], measures, right, strength=1e-9, balanced=True)
    # Of 30 right and 10 wrong, out of 40 right and 50 wrong; and of 10 and 40.
    odds = np.array([30 / 40 / (10 / 50), 10 / 40 / (40 / 50)])
    found = fit.probability(np.array([[0.0], [1.0]]))
    assert found == pytest.approx(odds / (1.0 + odds), abs=1e-4)


def test_weights_are_per_unit_of_the_measures() -> None:
    rng = np.random.default_rng(0)
    measures = rng.standard_normal((400, 2))
    right = rng.random(400) < 1 / (1 + np.exp(-measures @ [2.0, -1.0]))
    scales = np.array([1e-3, 50.0])
    one = fit_logistic(["a", "b"], measures, right)
    other = fit_logistic(["a", "b"], measures * scales + 7.0, right)
    for name, scale in zip("ab", scales, strict=True):
        assert other.weights[name] * scale == pytest.approx(one.weights[name], rel=1e-4)
        assert other.effects[name] == pytest.approx(one.effects[name], rel=1e-4)
    np.testing.assert_allclose(
        one.probability(measures), other.probability(measures * scales + 7.0), atol=1e-4
    )


def test_a_constant_measure_has_no_weight() -> None:
    measures = np.stack([np.arange(20.0), np.full(20, 3.0)], axis=1)
    fit = fit_logistic(["a", "constant"], measures, np.arange(20) > 9)
    assert fit.weights["constant"] == 0.0
    assert fit.weights["a"] > 0.0


def test_what_is_held_out_is_not_learned_from() -> None:
    rng = np.random.default_rng(1)
    measures = rng.standard_normal((60, 25))
    right = rng.random(60) < 0.5
    names = [str(k) for k in range(25)]
    fitted = fit_logistic(names, measures, right, strength=1e-6).probability(measures)
    held_out = held_out_probability(names, measures, right, strength=1e-6)
    # Noise can be learned by heart, and predicts nothing.
    assert np.mean((fitted - right) ** 2) < 0.2
    assert np.mean((held_out - right) ** 2) > 0.3


def answer(kind: str, error: float, probability: float, **measures: float) -> ConfidentAnswer:
    return ConfidentAnswer(kind, "as it is", error, probability, (), measures)


def test_features_are_read_as_they_were_written(tmp_path: Path) -> None:
    answers = [
        answer("people", 0.02, 0.9, fit=1.0, reach=2.0),
        answer("people", 0.2, 0.6, fit=3.0, reach=4.0),
        answer(DIFFERENT, np.inf, 0.3, fit=5.0, reach=6.0),
        answer("people", 0.02, 0.9, fit=7.0),
    ]
    path = tmp_path / "features.npz"
    save_features(path, answers)
    names, measures, right = load_features([path, path])
    assert names == ["fit", "reach"]
    assert measures.tolist() == [[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]] * 2
    assert right.tolist() == [True, False, False] * 2
    names, measures, _ = load_features([path], chosen=["fit"])
    assert (names, measures.ravel().tolist()) == (["fit"], [1.0, 3.0, 5.0, 7.0])
    save_features(tmp_path / "other.npz", [answer("people", 0.02, 0.9, other=1.0)])
    with pytest.raises(ValueError, match="different measures"):
        load_features([path, tmp_path / "other.npz"])
    with pytest.raises(ValueError, match="different measures"):
        load_features([path], chosen=["score"])
    save_features(tmp_path / "more.npz", [answer("people", 0.02, 0.9, fit=8.0, more=1.0)])
    with pytest.raises(ValueError, match="different measures"):
        load_features([path, tmp_path / "more.npz"])
    chosen = load_features([path, tmp_path / "more.npz"], chosen=["fit"])[1]
    assert chosen.ravel().tolist() == [1.0, 3.0, 5.0, 7.0, 8.0]


def test_pairs_of_different_classes_are_counted_apart() -> None:
    figures = report(
        [
            answer("people", 0.02, 1.0),
            answer("people", 0.2, 0.0),
            answer(DIFFERENT, np.inf, 0.3),
            answer(DIFFERENT, np.inf, 0.7),
        ]
    )
    assert figures["pairs"] == figures["different"] == 2
    assert figures["brier"] == 0.0
    assert figures["right"] == 0.5
    assert figures["doubted_of_different"] == 0.5
