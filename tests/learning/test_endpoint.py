"""Ends that the demonstrations leave ambiguous: the tube of a scene that tells the frames apart says so."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest

from pft_exec.demonstration import Demonstration, Scene
from pft_exec.geometry import Array, Pose
from pft_exec.learning import learn_motion
from tests.learning.taught import lesson

POST = np.array([0.42, -0.47, 1.12, 0.0, 0.0, 0.0, 1.0])


def _with_post(seed: int) -> list[Demonstration]:
    """`go_home` with a post that never moved, beside the place where the motion ends."""
    return [replace(d, objects={"post": POST}) for d in lesson("go_home", seed)]


def _end_covariance(demonstrations: list[Demonstration], moved: Array, **options: object) -> Array:
    motion = learn_motion(demonstrations, **options)  # type: ignore[arg-type]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        tube = motion.flow_tube(Scene({"post": Pose(POST[:3] + moved)}), demonstrations[0].start)
    return np.array(tube.covariance[-1, :3, :3])


@pytest.mark.parametrize("seed", range(3))
def test_where_rivals_contradict_the_chosen_frame_the_end_is_as_uncertain_as_the_decision(seed: int) -> None:
    demonstrations, moved = _with_post(seed), np.array([0.0, 0.3, 0.0])
    decision = learn_motion(demonstrations).variables.end.position
    assert decision.frame == "post"
    assert decision.rivals == ("absolute",)
    at_home, away = _end_covariance(demonstrations, np.zeros(3)), _end_covariance(demonstrations, moved)
    other = decision.probability["absolute"]
    share = other / (other + decision.probability["post"])
    np.testing.assert_allclose(away[1, 1] - at_home[1, 1], share * 0.3**2, rtol=0.25)
    np.testing.assert_allclose(away[[0, 2], [0, 2]], at_home[[0, 2], [0, 2]], rtol=0.2)


def test_a_user_who_names_the_frame_leaves_no_doubt() -> None:
    demonstrations, moved = _with_post(0), np.array([0.0, 0.3, 0.0])
    named = {"end": ["post"]}
    at_home, away = (_end_covariance(demonstrations, m, relevant=named) for m in (np.zeros(3), moved))
    np.testing.assert_allclose(np.trace(away), np.trace(at_home), rtol=0.2)
