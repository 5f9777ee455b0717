"""Recordings as streams: what is said of one belief after another."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pft_exec.demonstration import Demonstration
from pft_exec.exceptions import UnknownMethodError
from pft_exec.execution.log import BeliefHistory
from pft_exec.learning import MotionLibrary
from pft_exec.report import StreamRecognition, hold_out, plot_beliefs, recognition_rows, recognize_stream

from .conftest import demonstrate


def history(*rows: tuple[float, float]) -> BeliefHistory:
    return BeliefHistory(("lift", "reach"), np.arange(len(rows)) * 0.5, np.array(rows), np.full(len(rows), 0.1))


def test_the_decision_is_the_first_sample_from_which_the_final_label_led_without_a_break() -> None:
    result = StreamRecognition("reach", history((0.4, 0.6), (0.7, 0.3), (0.2, 0.8), (0.1, 0.9), (0.0, 1.0)))
    assert (result.label, result.is_right) == ("reach", True)
    assert result.decision_time == 1.0
    assert result.decision_share == 0.5
    assert result.share_right == pytest.approx(0.8)
    assert (result.probability, result.unknown) == (1.0, 0.1)


def test_a_label_that_led_throughout_was_decided_at_once() -> None:
    assert StreamRecognition("lift", history((0.9, 0.1), (0.8, 0.2))).decision_time == 0.0


def test_a_recording_of_a_motion_that_the_library_does_not_know_is_never_right() -> None:
    result = StreamRecognition("dance", history((0.9, 0.1), (0.8, 0.2)))
    assert not result.is_right
    assert result.share_right == 0.0
    np.testing.assert_array_equal(result.probability_of_truth, [0.0, 0.0])


@pytest.mark.parametrize("label", ["reach", "lift"])
def test_a_recording_nobody_learned_from_is_recognized(label: str, library: MotionLibrary) -> None:
    result = recognize_stream(library, demonstrate(label, seed=99))
    assert result.is_right
    np.testing.assert_allclose(result.history.probability.sum(axis=1), 1.0, atol=1e-9)
    assert len(result.history.time) == 60


def test_an_unknown_method_is_refused_with_the_nearest_one(library: MotionLibrary) -> None:
    with pytest.raises(UnknownMethodError, match="Did you mean 'phase'"):
        recognize_stream(library, demonstrate("reach", 0), "phse")


def test_rows_and_both_kinds_of_picture(
    library: MotionLibrary, demonstrations: list[Demonstration], tmp_path: Path
) -> None:
    """Few recordings get a panel each, many are drawn by motion."""
    results = [recognize_stream(library, item) for item in demonstrations]
    rows = recognition_rows(results)
    assert [row["motion"] for row in rows] == ["reach"] * 5 + ["lift"] * 5
    assert all(row["right"] for row in rows)
    plot_beliefs(results[:2], tmp_path / "few.png")
    plot_beliefs(results, tmp_path / "many.png")
    assert (tmp_path / "few.png").read_bytes() != (tmp_path / "many.png").read_bytes()


def test_held_out_demonstrations_and_the_others_are_all_of_them(demonstrations: list[Demonstration]) -> None:
    chosen, rest = hold_out(demonstrations, 3)
    assert [item.label for item in chosen] == ["reach"] * 3 + ["lift"] * 3
    assert chosen[:3] == demonstrations[:3]
    assert len(rest) == 4
    assert {id(item) for item in (*chosen, *rest)} == {id(item) for item in demonstrations}


def test_a_seed_draws_which_are_held_out_and_the_same_seed_the_same(demonstrations: list[Demonstration]) -> None:
    draws = [hold_out(demonstrations, 3, seed)[0] for seed in (0, 0, 1, 2, 3)]
    assert draws[0] == draws[1]
    assert any(draw != draws[0] for draw in draws[2:])
    assert all([item.label for item in draw] == ["reach"] * 3 + ["lift"] * 3 for draw in draws)


def test_more_than_there_are_holds_nothing_out(demonstrations: list[Demonstration]) -> None:
    assert hold_out(demonstrations, 50)[1] == []
