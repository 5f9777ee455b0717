"""Objects passed on the way: found where a place between the ends goes with them, told, asked for in a new scene."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from pft_exec.demonstration import Demonstration, Scene
from pft_exec.exceptions import MissingObjectError, UnknownNameError
from pft_exec.geometry import Array
from pft_exec.learning import learn_motion
from tests.learning.taught import scaled, turned

OVER = np.array([0.0, 0.0, 0.15])


def _placed(rng: np.random.Generator, low: float, high: float) -> Array:
    return np.array([rng.uniform(0.3, 0.7), rng.uniform(low, high), 0.0, *turned(rng.uniform(-1.0, 1.0))])


def passing(rng: np.random.Generator, is_passed: bool = True, samples: int = 100) -> Demonstration:
    """From anywhere to the tray, over the scanner where it is passed; a box lies about, a saucer is by the scanner."""
    start = rng.uniform([0.3, -0.5, 0.3], [0.6, -0.3, 0.4])
    scanner, tray, box = _placed(rng, -0.2, 0.2), _placed(rng, 0.3, 0.6), _placed(rng, -0.4, 0.4)
    goal = tray[:3] + OVER + rng.normal(0.0, 0.004, 3)
    middle = scanner[:3] + OVER + rng.normal(0.0, 0.006, 3) if is_passed else 0.5 * (start + goal)
    s = np.linspace(0.0, 1.0, samples)
    u = (10 * s**3 - 15 * s**4 + 6 * s**5) ** np.exp(rng.normal(0.0, 0.08))
    bulge = (2.0 * middle - 0.5 * (start + goal))[None]
    position = (1 - u[:, None]) ** 2 * start + 2 * (u * (1 - u))[:, None] * bulge + u[:, None] ** 2 * goal
    saucer = scanner + np.array([0.2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]) + np.append(rng.normal(0.0, 1e-4, 3), np.zeros(4))
    objects = {"scanner": scanner, "tray": tray, "box": box, "saucer": saucer}
    return Demonstration("scan", s * rng.uniform(1.8, 2.2), position, objects=objects)


def _lesson(seed: int = 0, count: int = 5, is_passed: bool = True) -> tuple[list[Demonstration], Demonstration]:
    rng = np.random.default_rng(seed)
    found = [passing(rng, is_passed) for _ in range(count + 1)]
    return found[:count], found[count]


def _without(demonstration: Demonstration, *names: str) -> Demonstration:
    kept = {name: pose for name, pose in demonstration.objects.items() if name not in names}
    return replace(demonstration, objects=kept)


def _off_the_way(demonstrations: list[Demonstration], new: Demonstration, **options: object) -> float:
    """How far the tube stays away from the place over the scanner, m."""
    tube = learn_motion(demonstrations, **options).flow_tube(new.scene, new.start)  # type: ignore[arg-type]
    place = new.scene["scanner"].position + OVER
    return float(np.linalg.norm(tube.position - place, axis=1).min())


def test_the_tube_passes_over_the_object_where_it_stands_now() -> None:
    lessons = [_lesson(seed) for seed in range(6)]
    found = np.array([_off_the_way(*lesson) for lesson in lessons])
    unknown = np.array([_off_the_way(*lesson, relevant={"way": []}) for lesson in lessons])
    assert found.max() < 0.04
    assert unknown.mean() > 3.0 * found.mean()


def test_a_passed_object_is_told_with_its_place_and_numbers() -> None:
    demonstrations, _ = _lesson()
    motion = learn_motion([_without(d, "saucer") for d in demonstrations])
    (passage,) = motion.variables.passed
    assert (passage.name, passage.rivals) == ("scanner", ())
    assert abs(passage.phase - 0.5) < 0.15
    np.testing.assert_allclose(passage.offset, OVER, atol=0.06)
    assert passage.spread < 0.3 * passage.spread_without
    assert "passes 0.15 m above scanner" in motion.describe()
    assert not motion.variables.ambiguous
    assert json.loads(json.dumps(motion.variables.to_dict()))["passed"][0]["name"] == "scanner"


def test_of_objects_that_moved_together_the_one_passed_closest_counts_and_the_other_is_named() -> None:
    demonstrations, _ = _lesson()
    motion = learn_motion(demonstrations)
    (passage,) = motion.variables.passed
    assert (passage.name, passage.rivals) == ("scanner", ("saucer",))
    assert motion.variables.ambiguous
    assert "AMBIGUOUS: it may as well be saucer" in motion.describe()


def test_a_passed_object_is_asked_for_and_no_other_is() -> None:
    demonstrations, new = _lesson()
    motion = learn_motion(demonstrations)
    objects = dict(new.scene.objects)
    motion.flow_tube(Scene({name: objects[name] for name in ("scanner", "tray")}), new.start)
    with pytest.raises(MissingObjectError, match="scanner"):
        motion.flow_tube(Scene({"tray": objects["tray"]}), new.start)


@pytest.mark.parametrize("count", [2, 3, 5])
def test_where_nothing_is_passed_nothing_is_found(count: int) -> None:
    found = [learn_motion(_lesson(seed, count, is_passed=False)[0]).variables.passed for seed in range(30)]
    assert sum(bool(passed) for passed in found) <= 1


def test_a_change_of_units_or_of_the_order_changes_no_passed_object() -> None:
    demonstrations, _ = _lesson()
    one = learn_motion(demonstrations).variables.passed
    for others in ([scaled(d, 1000.0) for d in demonstrations], demonstrations[::-1]):
        other = learn_motion(others).variables.passed
        assert [(p.name, p.axes, p.phase, p.rivals) for p in one] == [
            (p.name, p.axes, p.phase, p.rivals) for p in other
        ]


def test_the_user_says_what_is_passed() -> None:
    demonstrations, new = _lesson()
    none = learn_motion(demonstrations, relevant={"way": []})
    assert none.variables.passed == ()
    none.flow_tube(_without(new, "scanner", "box").scene, new.start)
    named = learn_motion(demonstrations, relevant={"way": ["box"]})
    assert [p.name for p in named.variables.passed] == ["box"]
    with pytest.raises(UnknownNameError):
        learn_motion(demonstrations, relevant={"way": ["start"]})


def test_each_piece_of_a_compound_motion_may_pass_an_object() -> None:
    demonstrations, _ = _lesson()
    whole = [replace(d, keyframes=(0.5 * (d.time[-2] + d.time[-1]),)) for d in demonstrations]
    (passage,) = learn_motion(whole).variables.passed
    assert passage.name == "scanner"
    assert passage.phase < 0.5
